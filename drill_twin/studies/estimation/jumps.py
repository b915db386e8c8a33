# SPDX-License-Identifier: Apache-2.0
"""Jumps of numbers: shown by the innovations of a channel, after which the numbers that it tells are drawn anew.

The filter has by then a spread that does not reach the new value. A share of the members is drawn again from the prior,
in those numbers alone to which the channel responds; the others keep what was learnt.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from drill_twin.core.arrays import Array, Mask
from drill_twin.studies.estimation.channel_errors import BEGIN, LIMIT

_WINDOWS = 2
"""Windows in a row, not explained, that show a jump."""
_ALONE, _APART = 10, 20
"""Windows after a jump in which the numbers that were drawn anew are corrected alone, and before the next jump: a
motion that has lost its phase with the load is no jump of friction."""
_TELLS = 0.5
"""Share of the variance of a number that its channel explains, from which the channel tells it."""
_KEPT = 0.97
"""Of that share, kept from window to window: a torque tells friction once in a cycle of stick-slip."""
_DIRECTIONS, _LEAST = 5, 0.01
"""Most directions of a channel that explain a number, and their least variance over that of the stated error."""


class Jumps:
    """Detector of jumps over windows of C channels, for d numbers.

    Attributes:
        since: Time of the jump [s] by key, of numbers that were drawn anew for `_APART` windows.
    """

    def __init__(self, channels: Sequence[str], keys: Sequence[str]) -> None:
        self.since: dict[str, float] = {}
        self._keys = list(keys)
        self._told: Array = np.zeros((len(channels), len(keys)))
        self._odd = np.zeros(len(channels), dtype=int)
        self._wait = BEGIN  # windows before the next jump

    @property
    def free(self) -> Mask | bool:
        """Numbers that may be corrected, shape (d,): after a jump those alone that were drawn anew; else all."""
        if not self.since or self._wait < _APART - _ALONE:
            return True
        return np.array([key in self.since for key in self._keys])

    def take(self, start: float, predicted: Array, numbers: Array, stated: Array, normalised: Array) -> Mask:
        """Take a window before its correction; returns the numbers that are to be drawn anew, shape (d,).

        Args:
            start: Its first time [s].
            predicted: Channels of the members, shape (N, C, S).
            numbers: Their numbers, shape (N, d).
            stated: Stated errors of a sample, shape (C,).
            normalised: Rms innovation of each channel over the predicted one, shape (C,); NaN where not measured.
        """
        told = np.array([explained(predicted[:, k] / error, numbers) for k, error in enumerate(stated)])
        self._told = np.maximum(_KEPT * self._told, told)
        self._odd = np.where(normalised > LIMIT, self._odd + 1, 0)
        if self._wait:
            self._wait -= 1
            return np.zeros(len(self._keys), dtype=bool)
        self.since = {}
        jumped = self._odd >= _WINDOWS
        anew: Mask = jumped[self._told.argmax(axis=0)] & (self._told.max(axis=0) > _TELLS)
        if anew.any():
            self.since = {key: start for key, of in zip(self._keys, anew, strict=True) if of}
            self._wait, self._odd[:] = _APART, 0
        return anew


def explained(predicted: Array, numbers: Array) -> Array:
    """Share of the variance of numbers, (N, d), explained by what members predict, (N, S) over its error, shape (d,).

    The coefficient of determination adjusted for its degrees of freedom (Ezekiel 1930), on the largest directions of
    the predictions.
    """
    members, size, _ = np.linalg.svd(predicted - predicted.mean(axis=0), full_matrices=False)
    count = len(numbers)
    most = min(_DIRECTIONS, count - 2, size.size)
    chosen = members[:, : max(1, min(most, int(np.count_nonzero(size**2 > _LEAST * (count - 1)))))]
    centred = numbers - numbers.mean(axis=0)
    total = np.maximum(np.sum(centred**2, axis=0), np.finfo(float).tiny)
    left = 1.0 - np.sum((chosen.T @ centred) ** 2, axis=0) / total
    return np.asarray(1.0 - left * (count - 1.0) / (count - 1.0 - chosen.shape[1]))


def told_of_jumps(since: Mapping[str, float]) -> str:
    """Sentence on numbers that are being looked for anew, by key with the time of the jump [s]; empty without."""
    parts = [f"{key} since {time:.1f} s" for key, time in since.items()]
    return f"looked for anew after a jump: {', '.join(parts)}" if parts else ""
