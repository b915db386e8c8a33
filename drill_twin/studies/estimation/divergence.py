# SPDX-License-Identifier: Apache-2.0
"""Alarm when measurement and twin part."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence

import numpy as np

from drill_twin.core.arrays import Array

_BEGIN = 10
"""Windows before the first alarm: numbers are still being found."""
_PAST = 60
"""Windows of which the usual misfit is the median."""
_RATIO = 4.0
"""Misfit over the usual one, from which a window is not explained."""
_LEAST = 0.05
"""Least misfit of a window that is not explained, over the scale of the channel."""
_WINDOWS = 3
"""Windows in a row that raise the alarm, or end it."""


class Divergence:
    """Misfit of C channels over the windows."""

    def __init__(self, channels: Sequence[str]) -> None:
        self._channels = list(channels)
        self._usual: list[deque[float]] = [deque(maxlen=_PAST) for _ in channels]
        self._odd = np.zeros(len(channels), dtype=int)
        self._good = np.zeros(len(channels), dtype=int)
        self._first = np.full(len(channels), np.nan)
        self._raised = np.zeros(len(channels), dtype=bool)

    @property
    def since(self) -> Mapping[str, float]:
        """Time since which each channel in alarm is not explained [s]."""
        return {name: float(self._first[k]) for k, name in enumerate(self._channels) if self._raised[k]}

    def take(self, start: float, misfit: Array) -> None:
        """Take a window.

        Args:
            start: Its first time [s].
            misfit: Rms of measured less predicted mean, over the channel's scale, shape (C,); NaN where nothing was
                measured.
        """
        for channel, value in enumerate(misfit):
            if not np.isfinite(value):
                continue
            usual = self._usual[channel]
            if len(usual) >= _BEGIN and value > max(_RATIO * float(np.median(usual)), _LEAST):
                if self._odd[channel] == 0 and not self._raised[channel]:
                    self._first[channel] = start
                self._odd[channel] += 1
                self._good[channel] = 0
            else:
                usual.append(float(value))
                self._good[channel] += 1
                self._odd[channel] = 0
            if self._odd[channel] >= _WINDOWS:
                self._raised[channel] = True
            elif self._good[channel] >= _WINDOWS:
                self._raised[channel] = False
