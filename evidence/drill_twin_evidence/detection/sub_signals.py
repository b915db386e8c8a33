# SPDX-License-Identifier: Apache-2.0
"""Readings of a sub on prescribed motions, each random with a seed, and the true onset of the motion.

Radii are fractions of the clearance, times are in revolutions. A section that only turns begins to whirl, or moves
aside and then whirls; its orbit grows at any pace, is round or oval, steady or unsteady in its rate.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drill_twin.core.arrays import Array, ComplexArray
from drill_twin.dynamics.sensors.motion import instantaneous
from drill_twin.whirl import MarkInfo
from drill_twin.whirl.downhole import ToolNoise
from drill_twin_evidence.detection.ground_truth import WHIRL_THRESHOLD, onset
from drill_twin_evidence.detection.sub_readings import BIAS, NOISE

HOLES = ((0.08175, 0.00825), (0.03675, 0.00825), (0.0539, 0.1016), (0.3, 0.09))
"""Clearance and outer radius [m]: the bench, the bench with 90 mm as diameter, 8 in in 12 1/4 in, and a wide hole."""
AFTER = 20.0
"""Length of the record after the orbit has reached the threshold [rev]."""
FINE = 4
"""Instants in a reading, which is their mean."""


class SubSignal(NamedTuple):
    """Readings of a sub on a prescribed motion; n readings."""

    name: str
    mark: MarkInfo
    """The section, as a mark on the centre."""
    radius: float
    """Distance of the sensor from the axis [m]."""
    noise: ToolNoise
    """Noise of the instruments, as the scene has it."""
    stamp: NDArray[np.int64]
    """Middle of the readings [ns], shape (n,)."""
    readings: Array
    """Specific force [m/s^2] and rates [rad/s], shape (n, 6)."""
    revolutions: Array
    """Revolutions at these times [rev], shape (n,)."""
    onset: float | None
    """True onset [s]."""
    ratio: float
    """Whirl ratio."""


def drawn_signal(seed: int) -> SubSignal:
    """Random motion of a section read by a sub, the same for the same seed."""
    draw = np.random.default_rng([seed, 14])
    clearance, outer = HOLES[int(draw.integers(len(HOLES)))]
    turn = float(np.exp(draw.uniform(math.log(0.7), math.log(5.0))))
    rate = turn * float(np.exp(draw.uniform(math.log(20.0), math.log(100.0))))
    kind, ratio = _ratio(draw)
    growth = float(np.exp(draw.uniform(math.log(0.06), math.log(4.0))))
    begin = float(draw.uniform(14.0, 60.0)) + min(3.0 / growth, 20.0)
    time = np.arange(int((begin + AFTER) / turn * rate) * FINE) / (rate * FINE)
    swing = draw.uniform(0.0, 0.03)
    angle = math.tau * turn * time + swing * np.sin(math.tau * turn * draw.uniform(0.1, 0.6) * time)
    part = _orbit(draw, angle, ratio, growth, begin)
    began = onset(time, part, angle)
    path = clearance * part
    lean = float(draw.choice([0.0, draw.uniform(0.05, 1.0)]))
    slope = float(draw.uniform(0.0, 0.25)) * np.exp(1j * draw.uniform(0.0, math.tau))
    radius = float(draw.uniform(0.2, 0.8)) * outer
    bent = draw.uniform(0.0, 0.05) * clearance * np.exp(1j * (angle + draw.uniform(0.0, math.tau)))
    ideal = _ideal(path + bent, slope * path, angle, 1.0 / (rate * FINE), lean, radius)
    noise = ToolNoise(*(float(np.exp(draw.uniform(-1.0, 1.5))) * level for level in NOISE))
    readings = ideal.reshape(-1, FINE, 6).mean(1) + np.repeat(noise, 3) * draw.normal(size=(ideal.shape[0] // FINE, 6))
    readings += np.repeat(BIAS, 3) * draw.normal(size=6)
    middle = time.reshape(-1, FINE).mean(1)
    name = f"{seed}: {kind}, ratio {ratio:.2f}, growth {growth:.2f}, {rate / turn:.0f} readings in a revolution"
    return SubSignal(
        name, MarkInfo("sub", 10.0, "centre", outer, clearance), radius, noise,
        np.round(middle * 1e9).astype(np.int64), readings, angle.reshape(-1, FINE).mean(1) / math.tau, began, ratio,
    )  # fmt: skip


def _ratio(draw: np.random.Generator) -> tuple[str, float]:
    kinds = {
        "forward": draw.uniform(0.15, 0.8),
        "fast": draw.uniform(1.2, 1.6),
        "backward": -draw.uniform(0.12, 1.2),
        "slow": draw.choice([-1.0, 1.0]) * draw.uniform(0.03, 0.12),
    }
    kind = str(draw.choice([*kinds], p=(0.4, 0.1, 0.3, 0.2)))
    return kind, float(kinds[kind])


def _orbit(draw: np.random.Generator, angle: Array, ratio: float, growth: float, begin: float) -> ComplexArray:
    """Motion over the clearance: an orbit that reaches the threshold at `begin`, and what the section does beside."""
    level = float(draw.uniform(0.08, 0.9))
    revolutions = angle / math.tau
    if draw.random() < 0.7:  # exponential, to a limit
        grown = WHIRL_THRESHOLD / level * np.exp(np.minimum(growth * (revolutions - begin), 50.0))
        size = level * grown / (1.0 + grown)
    else:  # in proportion to time, as a load that rises
        size = np.minimum(np.maximum(revolutions - begin, 0.0) * growth * level / 4.0, level)
    wander = np.cumsum(draw.normal(size=angle.size)) * math.sqrt(1.0 / max(1.0, angle.size / revolutions[-1]))
    phase = ratio * angle + float(draw.choice([0.0, draw.uniform(0.0, 0.3)])) * _smooth(wander, revolutions)
    part = np.exp(1j * (phase + draw.uniform(0.0, math.tau)))
    oval = float(draw.choice([0.0, draw.uniform(0.0, 0.4)]))
    part = part + oval * np.exp(-1j * (phase + draw.uniform(0.0, math.tau)))
    if draw.random() < 0.3:
        other = draw.uniform(0.0, 0.3) * np.exp(1j * (draw.uniform(-1.0, 1.5) * angle + draw.uniform(0.0, math.tau)))
        part = part + other
    part = size * part
    if draw.random() < 0.25:  # moves aside first
        since = (revolutions - begin + draw.uniform(0.0, 8.0)) / draw.uniform(0.1, 1.0)
        aside = draw.uniform(0.02, 0.3) * np.exp(1j * draw.uniform(0.0, math.tau))
        part = part + aside / (1.0 + np.exp(-np.clip(since, -50.0, 50.0)))
    found: ComplexArray = part
    return found


def _smooth(values: Array, revolutions: Array) -> Array:
    """Mean over half a revolution about each value."""
    width = max(1, round(0.5 * values.size / float(revolutions[-1])))
    found: Array = np.convolve(np.pad(values, width, "edge"), np.ones(width) / width, "same")[width:-width]
    return found


def _ideal(path: ComplexArray, tilt: ComplexArray, angle: Array, step: float, lean: float, radius: float) -> Array:
    """Readings of perfect sensors at instants `step` [s] apart, shape (n, 6)."""
    velocity = np.gradient(path, step)
    acceleration, swing = np.gradient(velocity, step), np.gradient(tilt, step)
    speed = np.gradient(angle, step)
    tangent = np.stack([tilt.real, tilt.imag, np.sqrt(1.0 - np.abs(tilt) ** 2)], -1)
    force = np.stack([
        acceleration.real - 9.81 * math.sin(lean), acceleration.imag, np.full_like(angle, 9.81 * math.cos(lean)),
    ], -1)  # fmt: skip
    across = swing * np.exp(-1j * angle)
    rates = np.stack([-across.imag, across.real, speed], -1)
    turned = np.gradient(rates, step, axis=0)
    return instantaneous(np.array(radius), force, tangent, angle, rates, turned)
