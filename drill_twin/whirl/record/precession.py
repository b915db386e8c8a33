# SPDX-License-Identifier: Apache-2.0
"""Precession of a mark over a whole record: interval over windows, mean, lines of the spectrum.

Offline, for reports. Irregular motion has no single frequency: the most frequent precession, the highest line and the
mean differ, and each of them depends on the length of the record.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from drill_twin.core.arrays import Array, ComplexArray
from drill_twin.whirl.marks import AnalysisError
from drill_twin.whirl.record.spectrum import Peak, two_sided_spectrum

WINDOW = 10.0
"""Length of a window [rev]."""
LINES = 3
"""Lines of the spectrum that are listed."""
SEGMENT = 4
"""Windows in a segment of the spectrum."""


@dataclass(frozen=True)
class PrecessionRecord:
    """Precession of a mark while the string whirls."""

    interval_hz: tuple[float, float] | None
    """Smallest and largest mean precession of a window of `WINDOW` revolutions [Hz], positive = the sense of rotation;
    weighted by the radius. None where the record is shorter than two windows."""
    mean_ratio: float | None
    """Mean ratio of precession to rotation, weighted by the radius."""
    lines: tuple[Peak, ...]
    """Highest lines of the spectrum, highest first; positive = the sense of rotation."""


def precession_record(
    time: Array, precession: Array, ratio: Array, radius: Array, centre: ComplexArray, rotation: float
) -> PrecessionRecord:
    """Precession of a mark from its findings at samples, shapes (n,), while the string whirls.

    Args:
        time: Times of the samples [s], rising.
        precession: Precession [rev/s], positive = forward; nan where unknown.
        ratio: Precession over rotation.
        radius: Distance of the centre line from the hole's axis [m].
        centre: Centre line z = x + i y [m].
        rotation: Mean rotation [rev/s], signed.
    """
    known = np.isfinite(ratio) & np.isfinite(precession) & (radius > 0.0)
    mean = float(np.average(ratio[known], weights=radius[known])) if known.any() else None
    return PrecessionRecord(
        _interval(time[known], precession[known], radius[known], abs(rotation)),
        mean,
        _lines(time, centre, rotation),
    )


def _interval(time: Array, precession: Array, radius: Array, rotation: float) -> tuple[float, float] | None:
    if time.size == 0 or rotation <= 0.0:
        return None
    window = np.floor((time - time[0]) * rotation / WINDOW).astype(np.intp)
    whole = math.floor((time[-1] - time[0]) * rotation / WINDOW + 1e-9)
    weight = np.bincount(window, radius, minlength=whole)[:whole]
    total = np.bincount(window, radius * precession, minlength=whole)[:whole]
    means = total[weight > 0.0] / weight[weight > 0.0]
    return (float(means.min()), float(means.max())) if means.size > 1 else None


def _lines(time: Array, centre: ComplexArray, rotation: float) -> tuple[Peak, ...]:
    segment = SEGMENT * WINDOW / abs(rotation) if rotation else None
    try:
        spectrum = two_sided_spectrum(time, centre, segment=segment)
    except AnalysisError:
        return ()  # too short a record
    sense = -1.0 if rotation < 0.0 else 1.0
    return tuple(Peak(sense * line.frequency, line.radius) for line in spectrum.lines(LINES))
