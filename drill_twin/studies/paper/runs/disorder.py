# SPDX-License-Identifier: Apache-2.0
"""How disordered a motion is, as a number: spectral entropy of an orbit, and the largest Lyapunov exponent of a run."""

from __future__ import annotations

import math

import numpy as np

from drill_twin.base.arrays import Array, ComplexArray
from drill_twin.scene import Scene
from drill_twin.schedule import Schedule
from drill_twin.studies.paper.runs.cases import changed
from drill_twin.twin.twin import Twin

LINES = 10.0
"""Highest frequency that counts [Hz]."""
SMALL = 1e-6
"""Distance at which two neighbouring runs are held, in metres of lateral place, root mean square over the nodes."""
TOLERANCE = 1e-8
"""Newton's tolerance of the two runs: with that of other runs they part by what each leaves unsolved, up to six times
as fast."""
EVERY = 0.05
"""Time after which their distance is measured and set back [s]."""


def spectral_entropy(time: Array, orbit: ComplexArray) -> float:
    """Entropy of the two-sided power spectrum of an orbit x + i y within 10 Hz, over its largest: 0 to 1.

    0 is one line (a circle), 1 is noise (Powell and Percival 1979). It grows with the resolution; compare equal
    lengths only.

    Args:
        time: Evenly spaced times [s], shape (T,).
        orbit: Centre line [m], shape (T,).
    """
    window = np.hanning(time.size)
    power = np.abs(np.fft.fft((orbit - orbit.mean()) * window)) ** 2
    frequency = np.fft.fftfreq(time.size, float(time[1] - time[0]))
    power = power[np.abs(frequency) <= LINES]
    share = power / power.sum()
    share = share[share > 0.0]
    return float(-(share * np.log(share)).sum() / math.log(power.size))


def largest_lyapunov(scene: Scene, since: float, seconds: float, seed: int = 1) -> float:
    """Mean rate at which neighbouring runs part [1/s] (Benettin et al. 1980), from `since` on.

    Two twins run side by side; every 0.05 s their distance is measured and set back along its direction. Distance is
    that of lateral places and velocities, the latter times 1 / (10 rad/s); memory of friction is not set back, which
    a distance this small does not feel.

    Args:
        scene: What to run.
        since: When the motion to be judged has begun [s].
        seconds: For how long to judge it [s].
        seed: Of the first difference.
    """
    scene = changed(scene, "numerics.tolerance", TOLERANCE)
    schedule, twin, other = Schedule.from_scene(scene), Twin(scene), Twin(scene)
    parted, counted, begin = 0.0, 0, round(since / EVERY)
    for step in range(1, round((since + seconds) / EVERY) + 1):
        command = schedule.at(step * EVERY)
        twin.advance(command, EVERY)
        other.advance(command, EVERY)
        if step == begin:
            velocity = other.unknowns[1][1:-1, 0:2]
            velocity += 10.0 * SMALL * np.random.default_rng(seed).normal(size=velocity.shape)
        elif step > begin and (distance := _distance(twin, other)) > 0.0:
            parted += math.log(distance / SMALL)
            counted += 1
            _set_back(twin, other, SMALL / distance)
    return parted / (counted * EVERY) if counted else 0.0


def _difference(twin: Twin, other: Twin) -> tuple[Array, Array]:
    (u, v), (other_u, other_v) = twin.unknowns, other.unknowns
    return other_u - u, other_v - v


def _distance(twin: Twin, other: Twin) -> float:
    place, velocity = (difference[:, 0:2] for difference in _difference(twin, other))
    return math.sqrt(float(np.mean((place**2 + (0.1 * velocity) ** 2).sum(axis=1))))


def _set_back(twin: Twin, other: Twin, factor: float) -> None:
    du, dv = _difference(twin, other)
    (u, v), (other_u, other_v) = twin.unknowns, other.unknowns
    other_u[:] = u + factor * du
    other_v[:] = v + factor * dv
