# SPDX-License-Identifier: Apache-2.0
"""Onset of whirl in a simulated run, from its full state, for the scores of one downhole sub.

Its numbers are those of the definition in `docs/analyzer.md`; the truth of the frozen records has none of them.
"""

from __future__ import annotations

import math

import numpy as np

from drill_twin.core.arrays import Array, ComplexArray, Mask
from drill_twin_evidence.detection.runs import Run

WHIRL_THRESHOLD = 0.05
"""Whirl: least radius of the asynchronous part over the clearance [-]."""
MIN_WHIRL = 1.0
"""Whirl: least duration above the threshold [rev]."""
TURN_WINDOW, MIN_TURN = 28.0, math.radians(30.0)
"""Whirl: window [rev], and least angle by which it turns within it [rad]."""
SYNCHRONOUS_WINDOW = 12.0
"""The synchronous part is the Hann-weighted mean over these past revolutions (at the start: over the first ones) in the
frame that rotates with the string [rev]."""


def revolutions_of(time: Array, speed: Array) -> Array:
    """Revolutions since the first sample [rev], non-decreasing, of a speed [rad/s]; shapes (T,)."""
    steps = 0.5 * np.abs(speed[1:] + speed[:-1]) * np.diff(time)
    return np.concatenate(([0.0], np.cumsum(steps))) / math.tau


def asynchronous(centre: ComplexArray, spin: Array, revolutions: Array) -> ComplexArray:
    """Centre line without its part synchronous with the spin [m]; all shapes (T, k), `revolutions` (T,)."""
    seen = centre * np.exp(-1j * spin)
    rest = np.empty_like(centre)
    first = np.searchsorted(revolutions, revolutions - SYNCHRONOUS_WINDOW, side="right")
    settled = min(int(np.searchsorted(revolutions, SYNCHRONOUS_WINDOW)), revolutions.size - 1)
    for i, start in enumerate(first.tolist()):
        past = slice(0, max(i, settled) + 1) if revolutions[i] < SYNCHRONOUS_WINDOW else slice(start, i + 1)
        weight = np.sin(math.pi * (revolutions[past] - revolutions[past.stop - 1]) / SYNCHRONOUS_WINDOW) ** 2
        part = (weight[:, None] * seen[past]).sum(axis=0) / max(float(weight.sum()), 1e-300)
        rest[i] = centre[i] - part * np.exp(1j * spin[i])
    return rest


def onset(time: Array, whirl: ComplexArray, angle: Array) -> float | None:
    """First time [s] from which a whirl over the clearance is above the threshold for a revolution; None if never.

    Whirl that does not turn is a static deflection: within `TURN_WINDOW` revolutions it must have turned by `MIN_TURN`,
    relative to the hole and to the string. `angle` is that of the rotation [rad]; all shapes (T,).
    """
    revolutions = np.abs(angle) / math.tau
    for start, end in _intervals(np.abs(whirl) > WHIRL_THRESHOLD):
        if revolutions[end] - revolutions[start] >= MIN_WHIRL:
            stop = min(end, int(np.searchsorted(revolutions, revolutions[start] + TURN_WINDOW)))
            way = np.unwrap(np.angle(whirl[start : stop + 1]))
            if min(np.ptp(way), np.ptp(way - angle[start : stop + 1])) > MIN_TURN:
                return float(time[start])
    return None


def _intervals(flag: Mask) -> list[tuple[int, int]]:
    """First and last index of each interval of True."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], flag, [False])).astype(np.int8)))
    return [(int(a), int(b) - 1) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def mark_onsets(run: Run) -> tuple[float | None, ...]:
    """Onset of whirl at each mark of a run in a vertical hole [s]."""
    revolutions = revolutions_of(run.time, run.top_speed)
    whirl = asynchronous(run.mark_centre, run.mark_spin, revolutions)
    angle = math.tau * revolutions * (-1.0 if run.top_speed[-1] < 0.0 else 1.0)
    return tuple(onset(run.time, whirl[:, k] / mark.clearance, angle) for k, mark in enumerate(run.marks))
