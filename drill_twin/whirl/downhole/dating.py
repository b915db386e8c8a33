# SPDX-License-Identifier: Apache-2.0
"""Time of the onset of a whirl from the readings of a sub, found backwards once the whirl is detected.

The high pass shortens and delays an orbit that begins, since what grows slowly is nearly constant. So the readings are
integrated again without it, from a record before the onset over which the position is known to be small: there
position, velocity, and what is constant in the frames of the hole and of the string are fitted, and kept afterwards.
The time at which the radius crosses the threshold moves that record, until it stays.
"""

from __future__ import annotations

import numpy as np

from drill_twin.base.arrays import Array, ComplexArray
from drill_twin.whirl.criteria import Criteria
from drill_twin.whirl.downhole.motion import Record

BEFORE = 8.0
"""Length of the record over which the position is small [rev]."""
MARGIN = 1.0
"""It ends this long before the onset [rev]."""
SHORTEST = 3.0
"""Least length of it [rev]."""
LEANING = 0.1
"""Mean acceleration from which a bias of the gyroscope turns gravity enough to be fitted [m/s^2]."""
MOST = 8
"""Most times that it is moved."""
CLOSE = 0.02
"""It is moved no more where the onset moves by less [rev]."""


def crossing(record: Record, clearance: float, guess: float, until: float) -> float | None:
    """Time at which the radius crossed the threshold of an onset [s]; None where the record does not tell.

    Args:
        record: The readings.
        clearance: Lateral clearance of the section [m].
        guess: Time at which it may have crossed [s].
        until: Time of the detection [s].
    """
    revolutions = record.revolutions
    limit = Criteria().onset_radius * clearance
    begun, detected = np.interp([guess, until], record.stamp, revolutions).tolist()
    found = None
    for _ in range(MOST):
        radius, first = _anchored(record, begun - MARGIN, detected)
        if first < 0:
            break
        after = _first_crossing(np.abs(radius), revolutions[first : first + radius.size], limit)
        if after is None:
            break
        found, moved = after, after - begun
        begun = after
        if abs(moved) < CLOSE:
            break
    return None if found is None else float(np.interp(found, revolutions, record.stamp))


def _anchored(record: Record, anchor: float, until: float) -> tuple[ComplexArray, int]:
    """Position [m] from `BEFORE` the end of the anchor to a time [rev], and its first sample; -1 if it is short."""
    revolutions = record.revolutions
    first, end, last = np.searchsorted(revolutions, [anchor - BEFORE, anchor, until]).tolist()
    none: ComplexArray = np.zeros(0, complex)
    if end <= first or revolutions[end - 1] - revolutions[first] < SHORTEST or last - end < 2:
        return none, -1
    rows = slice(first, last + 1)
    position, along = _twice(record.acceleration[rows]), _twice(record.turn[rows])
    time = np.arange(1.0, position.size + 1.0) / (end - first)
    before = slice(0, end - first)
    leans = abs(record.acceleration[rows][before].mean()) > LEANING
    powers = [time**power + 0j for power in range(4 if leans else 3)]
    columns = np.stack([*powers, along / np.abs(along[before]).max()], -1)
    fitted = np.linalg.lstsq(columns[before], position[before], rcond=None)[0]
    interval = float(np.mean(np.diff(record.stamp[rows])))
    found: ComplexArray = (position - columns @ fitted) * interval**2
    return found, first


def _twice(acceleration: ComplexArray) -> ComplexArray:
    """Integral of the integral of means over intervals, at their ends, in units of the interval squared."""
    velocity = np.cumsum(acceleration)
    found: ComplexArray = np.cumsum(velocity - 0.5 * acceleration)
    return found


def _first_crossing(radius: Array, revolutions: Array, limit: float) -> float | None:
    """First time [rev] from which a radius is above a limit for `sustain`, or to the end; None if never."""
    above = np.concatenate([[False], radius > limit, [False]])
    edges = np.flatnonzero(np.diff(above.astype(np.int8)))
    for begin, end in zip(edges[::2].tolist(), (edges[1::2] - 1).tolist(), strict=True):
        if end == radius.size - 1 or revolutions[end] - revolutions[begin] >= Criteria().sustain:
            low, high = float(radius[max(begin - 1, 0)]), float(radius[begin])
            share = (limit - low) / (high - low) if high > limit > low else 1.0
            step = revolutions[begin] - revolutions[max(begin - 1, 0)]
            return float(revolutions[begin] - (1.0 - share) * step)
    return None
