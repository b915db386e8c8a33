# SPDX-License-Identifier: Apache-2.0
"""Errors of measured channels: by how much a sample may differ from the model, raised where it differs by more."""

from __future__ import annotations

from collections.abc import Sequence

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
    def stated(self) -> Array:
        """Standard deviation that is stated for the error of a sample of each channel, shape (C,)."""
        return np.maximum(self._share * self.scale, self._least)

    @property
    def deviation(self) -> Array:
        """The same with what innovations have shown, shape (C,)."""
        return np.maximum(np.sqrt(self._raised), self.stated)

    def forget(self) -> None:
        """Forget what innovations have shown: they were of a jump."""
        self._raised[:] = 0.0

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


LIMIT = 3.0
"""Rms innovation of a window over the predicted one, from which the window is not explained. Its samples may err alike:
then it is the size of one normal value, which is larger in 0.3 % of the windows of a model that is right."""
