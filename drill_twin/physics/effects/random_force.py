# SPDX-License-Identifier: Apache-2.0
"""Seeded random lateral force on the string, a lumped model of cuttings, flow and an uneven hole."""

import math
from typing import Annotated, Any, NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.compile.jit import kernel
from drill_twin.core.units import ForcePerLength, Length, Time, Within
from drill_twin.physics.effects.config import EffectConfig, Seed
from drill_twin.physics.effects.random_draws import generator, normal_strata
from drill_twin.physics.model import DiscreteModel, Point, Rod

WAVES, HARMONICS = 16, 32  # shapes along the string, and harmonics in time of each


class RandomForce(EffectConfig):
    """Lateral force per length, Gaussian in arc length and time: mean zero, no direction preferred.

    Its correlation is rms^2 exp(-(s / l)^2 / 2 - (t / tau)^2 / 2). It is a function of arc length and time, hence
    independent of mesh, step and frame rate.
    """

    across = True
    disabled_for_static = ("rms",)

    rms: Annotated[
        ForcePerLength, Within(at_least="0 N/m", at_most="1e6 N/m", reason="200 times the weight of a heavy collar")
    ]
    """Root mean square of the force per length, both directions together [N/m]."""
    correlation_time: Annotated[Time, Within(at_least="1 us", at_most="1e6 s", reason="shorter than any step")]
    """Correlation time tau, at which the correlation is exp(-1/2) [s]; the spectrum is small above 1/(2 tau)."""
    correlation_length: Annotated[Length, Within(above="0 m", at_most="20 km", reason="the longest string")]
    """Correlation length l along the string, at which the correlation is exp(-1/2) [m]."""
    seed: Seed = 1
    """Seed; the same seed gives the same force."""


class Parameters(NamedTuple):
    """Force x + i y as sum over shapes m of exp(i k_m s) times the sum over j of exp(i (w_mj t + phi_mj))."""

    shape: Array  # rms exp(i k s) / sqrt(all), real and imaginary part [N/m], (2 n, WAVES, 2)
    frequency: Array  # [rad/s], (WAVES, HARMONICS)
    phase: Array  # [rad], (WAVES, HARMONICS)
    swing: Array  # the sums over j at the time below, (WAVES, 2)
    now: Array  # the time they hold for [s], (1,)


def parameters(block: RandomForce, model: DiscreteModel) -> Parameters:
    """Draw wave numbers, frequencies and phases (`drill_twin.physics.effects.random_draws`)."""
    random = generator(model, block.seed, "random_force")
    number = WAVES * HARMONICS
    waves = normal_strata(random, WAVES) / block.correlation_length
    turns = block.rms / np.sqrt(number) * np.exp(1j * np.multiply.outer(model.places, waves))
    return Parameters(
        shape=np.stack([turns.real, turns.imag], -1),
        frequency=(normal_strata(random, number) / block.correlation_time).reshape(WAVES, HARMONICS),
        phase=random.uniform(0.0, math.tau, (WAVES, HARMONICS)),
        swing=np.zeros((WAVES, 2)),
        now=np.full(1, np.nan),
    )


@kernel
def update_harmonics(law: Parameters, time: float) -> None:
    """Evaluate the sums over the harmonics at a time, once for all points of a step."""
    law.now[0] = time
    for m in range(law.frequency.shape[0]):
        real, imaginary = 0.0, 0.0
        for j in range(law.frequency.shape[1]):
            angle = law.frequency[m, j] * time + law.phase[m, j]
            real += np.cos(angle)
            imaginary += np.sin(angle)
        law.swing[m, 0] = real
        law.swing[m, 1] = imaginary


@kernel
def distributed_load(parameters: Any, rod: Rod, here: Point, half_step: float, load: Array, stiff: Array) -> None:
    """Add the force at this point and time."""
    law = parameters.random_force
    if here.time != law.now[0]:
        update_harmonics(law, here.time)
    for m in range(law.swing.shape[0]):
        real, imaginary = law.shape[here.place, m, 0], law.shape[here.place, m, 1]
        load[0] += real * law.swing[m, 0] - imaginary * law.swing[m, 1]
        load[1] += real * law.swing[m, 1] + imaginary * law.swing[m, 0]
