# SPDX-License-Identifier: Apache-2.0
"""Readings of one downhole sub at the frames of a window: missing, repeated, late, frozen and impossible ones."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np

from drill_twin.base.arrays import Array
from drill_twin.estimation.members import Pace
from drill_twin.estimation.subs import VALUES
from drill_twin.scene.blocks.sensors import Sub

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
        self._last: tuple[float, Array] | None = None  # of the window before

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
        pace = self._pace
        middles = start + pace.period * (0.5 + np.arange(pace.frames))
        end = start + pace.window
        own = sorted(time for time in self._open if time <= end)
        later = min((time for time in self._open if time > end), default=None)
        points = [(time, self._open[time]) for time in own]
        last, self._last = self._last, points[-1] if points else self._last
        if last is not None:
            points.insert(0, last)
        if later is not None:
            points.append((later, self._open[later]))
        self._open = {time: values for time, values in self._open.items() if time > end}
        times = np.clip([time for time, _ in points], start, end)
        if not own or np.max(np.diff(times, prepend=start, append=end)) > _GAP / self._rate:
            self._troubles["window without readings"] += 1
            return np.full((pace.frames, VALUES), np.nan)
        values = np.array([values for _, values in points])
        if len(own) >= _FEWEST and not np.ptp(values, axis=0).any():
            self._troubles["frozen readings"] += 1
            return np.full((pace.frames, VALUES), np.nan)
        return np.stack([np.interp(middles, [time for time, _ in points], column) for column in values.T], axis=-1)
