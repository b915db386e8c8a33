# SPDX-License-Identifier: Apache-2.0
"""Prescribed lateral motion of the top clamp."""

import math
from collections.abc import Iterator
from typing import Annotated, Any, NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.compile.jit import kernel
from drill_twin.core.units import Angle, Frequency, Length, Within
from drill_twin.physics.effects.config import EffectConfig, Problem, Seed, too_large
from drill_twin.physics.effects.random_draws import HARMONICS, generator, normal_strata
from drill_twin.physics.model import DiscreteModel, Rod


class TopShake(EffectConfig):
    """Lateral motion A sin(2 pi f t) of the top clamp, or a random motion of the same mean square around f."""

    disabled_for_static = ("amplitude",)
    seed_is_of = "bandwidth"

    amplitude: Annotated[Length, Within(at_least="0 m", at_most="10 m", reason="the widest hole")]
    """Amplitude A [m]; for a random motion sqrt(2) times the root mean square."""
    frequency: Annotated[Frequency, Within(at_least="0 Hz", at_most="1 kHz", reason="above, no frame would show it")]
    """Frequency f [Hz]; for a random motion the centre of its band."""
    direction: Annotated[Angle, Within(at_least="-360 deg", at_most="360 deg", reason="a turn")] = 0.0
    """Direction across the hole, from +x towards +y [rad]."""
    bandwidth: Annotated[Frequency, Within(at_least="0 Hz", at_most="1 kHz", reason="as for the frequency")] = 0.0
    """Width of a Gaussian spectrum around the frequency (standard deviation) [Hz]; 0 Hz = one sine."""
    seed: Seed = 1
    """Random motion: seed."""

    def check_against(self, scene: Any) -> Iterator[Problem]:
        """Yield an amplitude above the clearance."""
        clearance = scene.least_clearance
        yield from too_large(("amplitude",), self.amplitude, clearance, "clearance in the hole", below=True)


class Parameters(NamedTuple):
    """Velocity as sum of harmonics speed_j cos(frequency_j t + phase_j) along a direction."""

    speed: Array  # [m/s], (m,)
    frequency: Array  # [rad/s], (m,)
    phase: Array  # [rad], (m,)
    along_x: float
    along_y: float


def parameters(block: TopShake, model: DiscreteModel) -> Parameters:
    """Compute one harmonic, or draw the harmonics of a random motion."""
    hertz, phase, amplitude = np.full(1, block.frequency), np.zeros(1), block.amplitude
    if block.bandwidth > 0.0:
        random = generator(model, block.seed, "top_shake")
        hertz = block.frequency + block.bandwidth * normal_strata(random, HARMONICS)
        phase, amplitude = random.uniform(0.0, math.tau, HARMONICS), block.amplitude / np.sqrt(HARMONICS)
    omega = math.tau * hertz
    return Parameters(amplitude * omega, omega, phase, float(np.cos(block.direction)), float(np.sin(block.direction)))


def initial_state(block: TopShake, model: DiscreteModel, u: Array, v: Array) -> None:
    """Set the velocity of the top at the first instant."""
    shake = parameters(block, model)
    speed = float(np.sum(shake.speed * np.cos(shake.phase)))
    v[-1, 0] += speed * shake.along_x
    v[-1, 1] += speed * shake.along_y


@kernel
def top_speed(shake: Parameters, time: float) -> float:
    """Velocity of the top along its direction at a time [m/s]."""
    speed = 0.0
    for j in range(shake.speed.shape[0]):
        speed += shake.speed[j] * np.cos(shake.frequency[j] * time + shake.phase[j])
    return speed


@kernel
def prescribed_motion(parameters: Any, rod: Rod, time: float, trial: Array) -> None:
    """Prescribe the velocity of the top at mid-step."""
    speed, last = top_speed(parameters.top_shake, time), trial.shape[0] - 1
    trial[last, 0] = speed * parameters.top_shake.along_x
    trial[last, 1] = speed * parameters.top_shake.along_y


@kernel
def after_step(parameters: Any, rod: Rod, command: Array, time: float, step: float, u: Array, v: Array) -> None:
    """Set the velocity of the top at the end of the step, which would oscillate with the midpoint rule alone."""
    speed, last = top_speed(parameters.top_shake, time), v.shape[0] - 1
    v[last, 0] = speed * parameters.top_shake.along_x
    v[last, 1] = speed * parameters.top_shake.along_y
