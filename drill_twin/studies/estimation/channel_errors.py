# SPDX-License-Identifier: Apache-2.0
"""Errors of measured channels: by how much a sample may differ from the model, raised where it differs by more."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence

import numpy as np

from drill_twin.core.arrays import Array

_MEMORY = 10.0
"""Windows over which a raised error fades."""
_GATE = 8.0
"""Standard deviations from which a sample is absurd, if most of its channel's are not."""


class ChannelErrors:
    """Standard deviations of C channels.

    Attributes:
        scale: Largest size of each channel so far [SI], shape (C,).
        absurd: Samples that were left out so far.
    """

    def __init__(self, channels: Sequence[str], share: float, floor: Array | float = 0.0) -> None:
        """Begin.

        Args:
            channels: Names.
            share: Error of sensor and model together, as a share of the channel's scale.
            floor: Least error of a sample, of a noise that is known, shape (C,).
        """
        self.channels, self._share = list(channels), share
        self.scale: Array = np.zeros(len(channels))
        self._raised: Array = np.zeros(len(channels))
        self._least: Array = np.maximum(floor, np.full(len(channels), np.finfo(float).tiny ** 0.25))
        self.absurd = 0

    @property
    def deviation(self) -> Array:
        """Standard deviation of a sample of each channel, shape (C,)."""
        return np.maximum(np.sqrt(self._raised), np.maximum(self._share * self.scale, self._least))

    def screen(self, predicted: Array, measured: Array) -> Array:
        """Measured samples, NaN for those that are absurd beside the others of their channel.

        Args:
            predicted: Of N members, shape (N, C, S).
            measured: Shape (C, S).
        """
        with np.errstate(invalid="ignore"):
            self.scale = np.fmax(self.scale, np.abs(predicted).max(axis=(0, 2)))
            width = np.sqrt(predicted.var(axis=0, ddof=1) + self.deviation[:, None] ** 2)
            off = np.abs(measured - predicted.mean(axis=0)) > _GATE * width
        known = np.isfinite(measured).sum(axis=1)
        few = off.sum(axis=1) < 0.5 * np.maximum(known, 1)
        off &= few[:, None]
        self.absurd += int(off.sum())
        return np.where(off, np.nan, measured)

    def learn(self, measured: Array, before: Array, after: Array) -> None:
        """Raise the errors that the innovations show (Desroziers, Berre, Chapnik and Poli 2005, Eq. 1).

        Args:
            measured: Shape (C, S); NaN where missing.
            before: Mean of the members before the correction, shape (C, S).
            after: The same after it.
        """
        product = np.where(np.isfinite(measured), (measured - after) * (measured - before), 0.0)
        found = product.sum(axis=1) / np.maximum(np.isfinite(measured).sum(axis=1), 1)
        self._raised = np.maximum(self._raised + (found - self._raised) / _MEMORY, 0.0)


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


class ModelMismatchAlarm:
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
