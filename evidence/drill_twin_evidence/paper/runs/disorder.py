# SPDX-License-Identifier: Apache-2.0
"""Measures of disorder: spectral entropy of an orbit, and largest Lyapunov exponent of a run."""

from __future__ import annotations

import math

import numpy as np

from drill_twin.core.arrays import Array, ComplexArray
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.scene import Scene
from drill_twin.scene.set_points import Schedule
from drill_twin_evidence.paper.runs.cases import changed

MAX_FREQUENCY = 10.0
"""Highest frequency of the entropy [Hz]."""
DISTANCE = 1e-6
"""Distance of two neighbouring runs after rescaling: rms lateral distance of the nodes [m]."""
TOLERANCE = 1e-8
"""Tolerance of Newton's method in the two runs: at that of other runs, residuals diverge six times as fast."""
INTERVAL = 0.05
"""Interval between rescalings of the distance [s]."""


def spectral_entropy(time: Array, orbit: ComplexArray) -> float:
    """Entropy of the two-sided power spectrum of an orbit x + i y within 10 Hz, over its largest: 0 to 1.

    0 is one line (a circle), 1 is noise (Powell and Percival 1979). It grows with the frequency resolution;
    compare records of equal length only.

    Args:
        time: Evenly spaced times [s], shape (T,).
        orbit: Centre line [m], shape (T,).
    """
    window = np.hanning(time.size)
    power = np.abs(np.fft.fft((orbit - orbit.mean()) * window)) ** 2
    frequency = np.fft.fftfreq(time.size, float(time[1] - time[0]))
    power = power[np.abs(frequency) <= MAX_FREQUENCY]
    share = power / power.sum()
    share = share[share > 0.0]
    return float(-(share * np.log(share)).sum() / math.log(power.size))


def largest_lyapunov(scene: Scene, since: float, seconds: float, seed: int = 1) -> float:
    """Largest Lyapunov exponent [1/s]: mean rate of divergence of neighbouring runs (Benettin et al. 1980).

    Two twins run in parallel; every 0.05 s their distance is measured and rescaled along its direction. It is the
    distance of lateral positions and velocities, the latter times 1 / (10 rad/s). The state of friction is not
    rescaled, which does not matter at so small a distance.

    Args:
        scene: The scene.
        since: Start of the evaluation [s].
        seconds: Length of the evaluation [s].
        seed: Seed of the initial difference.
    """
    scene = changed(scene, "numerics.tolerance", TOLERANCE)
    schedule, twin, other = Schedule.from_scene(scene), Twin(scene), Twin(scene)
    parted, counted, begin = 0.0, 0, round(since / INTERVAL)
    for step in range(1, round((since + seconds) / INTERVAL) + 1):
        command = schedule.at(step * INTERVAL)
        twin.advance(command, INTERVAL)
        other.advance(command, INTERVAL)
        if step == begin:
            velocity = other.unknowns[1][1:-1, 0:2]
            velocity += 10.0 * DISTANCE * np.random.default_rng(seed).normal(size=velocity.shape)
        elif step > begin and (distance := _distance(twin, other)) > 0.0:
            parted += math.log(distance / DISTANCE)
            counted += 1
            _rescale(twin, other, DISTANCE / distance)
    return parted / (counted * INTERVAL) if counted else 0.0


def _difference(twin: Twin, other: Twin) -> tuple[Array, Array]:
    (u, v), (other_u, other_v) = twin.unknowns, other.unknowns
    return other_u - u, other_v - v


def _distance(twin: Twin, other: Twin) -> float:
    place, velocity = (difference[:, 0:2] for difference in _difference(twin, other))
    return math.sqrt(float(np.mean((place**2 + (0.1 * velocity) ** 2).sum(axis=1))))


def _rescale(twin: Twin, other: Twin, factor: float) -> None:
    du, dv = _difference(twin, other)
    (u, v), (other_u, other_v) = twin.unknowns, other.unknowns
    other_u[:] = u + factor * du
    other_v[:] = v + factor * dv
