# SPDX-License-Identifier: Apache-2.0
"""Readings of one downhole sub at the frames of a window: missing, repeated, late, frozen and impossible ones."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from operator import itemgetter

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.scene.blocks.sensors import Sub
from drill_twin.studies.estimation.prediction import Pace
from drill_twin.studies.estimation.subs import VALUES

_LARGEST = 1e5
"""Largest reading where the scene gives no range: 10 000 g."""
_GAP = 3.5
"""Intervals between readings over which they are interpolated; a window with a longer gap goes without the sub."""
_FEWEST = 8
"""Readings of a window, from which equal ones are frozen."""


class SubIntake:
    """Readings of a sub on their way to windows."""

    def __init__(self, pace: Pace, sub: Sub, troubles: Counter[str]) -> None:
        self._pace, self._rate, self._troubles = pace, sub.rate, troubles
        ranges = [sub.accelerometer.range or _LARGEST] * 3 + [sub.gyroscope.range or _LARGEST] * 3
        self._largest = np.array(ranges)
        self._open: dict[float, Array] = {}
        self._last: list[tuple[float, Array]] = []  # of the window before, or none

    def take(self, time: float, values: Sequence[float]) -> None:
        """Take a reading of six values, by its time in the ensemble [s]."""
        reading = np.asarray(values, float)
        if not np.all(np.abs(reading) <= self._largest):
            self._troubles["impossible reading"] += 1
        elif time in self._open:
            self._troubles["repeated reading"] += 1
        else:
            self._open[time] = reading

    def close(self, start: float) -> Array:
        """Readings at the middles of the frames of the window that starts at a time [s], shape (F, 6); NaN without."""
        pace, end = self._pace, start + self._pace.window
        middles = start + pace.period * (0.5 + np.arange(pace.frames))
        given = sorted(self._open.items(), key=itemgetter(0))
        own, after = [each for each in given if each[0] <= end], [each for each in given if each[0] > end]
        points = [*self._last, *own, *after[:1]]
        self._open, self._last = dict(after), own[-1:] or self._last
        times = np.array([time for time, _ in points])
        gaps = np.diff(np.clip(times, start, end), prepend=start, append=end)
        if not own or gaps.max() > _GAP / self._rate:
            self._troubles["window without readings"] += 1
        elif len(own) >= _FEWEST and not np.ptp([values for _, values in own], axis=0).any():
            self._troubles["frozen readings"] += 1
        else:
            columns = np.array([values for _, values in points]).T
            return np.stack([np.interp(middles, times, column) for column in columns], axis=-1)
        return np.full((pace.frames, VALUES), np.nan)
