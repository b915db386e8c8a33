# SPDX-License-Identifier: Apache-2.0
"""Jumps of numbers: shown by the innovations of a channel, and explained by one that it tells, or by none.

They are shown by windows that are not explained. The filter has by then a spread that does not reach the new value.
What explains the jump is found by restarts (`drill_twin_studies.estimation.restarts`) and is looked for anew; the other
numbers are held as they were.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from drill_twin.core.arrays import Array, Mask
from drill_twin_studies.estimation.channel_errors import LIMIT
from drill_twin_studies.estimation.doubts import BEGIN, JUMP_WINDOWS

_ALONE, _APART, _LONGEST = 10, 20, 80
"""Windows after a jump in which the numbers that explain it are corrected alone, and before the next jump: a motion
that has lost its phase with the load is no jump of friction. Where none explains a large one, all are held until the
next, and the time to it doubles, as restarts cost some windows of computing."""
_TELLS = 0.5
"""Share of the variance of a number that its channel explains, from which the channel tells it."""
_KEPT = 0.97
"""Of that share, kept from window to window: a torque tells friction once in a cycle of stick-slip."""
_DIRECTIONS, _LEAST = 5, 0.01
"""Most directions of a channel that explain a number, and their least variance over that of the stated error."""

UNEXPLAINED = "none of the numbers"
"""Key of a jump that no number explains."""


class Jumps:
    """Detector of jumps over windows of C channels, for d numbers.

    Attributes:
        since: Time of the jump [s] by key of each number that explains it, for `_APART` windows; of `UNEXPLAINED`, if
            none does.
    """

    def __init__(self, channels: Sequence[str], keys: Sequence[str]) -> None:
        self.since: dict[str, float] = {}
        self._keys = list(keys)
        self._told: Array = np.zeros((len(channels), len(keys)))
        self._odd = np.zeros(len(channels), dtype=int)
        self._wait = BEGIN  # windows before the next jump
        self._apart = _APART

    @property
    def free(self) -> Mask | bool:
        """Numbers that may be corrected, shape (d,): after a jump those alone that explain it; else all."""
        if UNEXPLAINED not in self.since and (not self.since or self._wait < _APART - _ALONE):
            return True
        return np.array([key in self.since for key in self._keys])

    def take(self, predicted: Array, numbers: Array, stated: Array, normalised: Array) -> Mask:
        """Take a window before its correction; returns the numbers that may explain a jump, shape (d,).

        Args:
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
        teller, known = self._told.argmax(axis=0), self._told.max(axis=0) > _TELLS
        may: Mask = (self._odd >= JUMP_WINDOWS)[teller] & known
        if not may.any():
            self.since = {}
        return may

    def explain(self, start: float, chosen: Mask | None) -> None:
        """Take what explains the last windows.

        Args:
            start: First time of the window that showed the jump [s].
            chosen: Numbers that have jumped, shape (d,), none where the motion was lost; None if nothing explains it.
        """
        wait = _APART
        if chosen is not None:
            self.since = {key: start for key, of in zip(self._keys, chosen, strict=True) if of}
        else:
            wait = min(2 * self._apart, _LONGEST) if UNEXPLAINED in self.since else _APART
            self.since = {UNEXPLAINED: self.since.get(UNEXPLAINED, start)}
        self._odd[:], self._wait, self._apart = 0, wait, max(wait, _APART)


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
    if UNEXPLAINED in since:
        return f"a jump at {since[UNEXPLAINED]:.1f} s that {UNEXPLAINED} explains: they are held as they were"
    parts = [f"{key} since {time:.1f} s" for key, time in since.items()]
    return f"looked for anew after a jump: {', '.join(parts)}" if parts else ""
