# SPDX-License-Identifier: Apache-2.0
"""Doubts in a model, and jumps of its numbers: what is measured differs from what members and noise allow.

The squared innovation of a window over its covariance, from the members and the noise of the record, is about
the number of its samples where the model is right, even while its numbers are still being found (Bar-Shalom, Li and
Kirubarajan 2001, section 5.4). What lies above that number is summed up (Page 1954). So a small misfit that lasts
counts as much as a large one, and a model that was wrong is believed again only after it has been right for long. Until
then its numbers may be bent.

A number that jumps is shown by windows in a row that the members do not explain: by then the spread of the filter does
not reach the new value. Restarts (`drill_twin_studies.estimation.restarts`) find the number that explains the jump. The
filter looks for that number anew, and holds the others as they were.
"""

from collections import deque
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array, Mask
from drill_twin_studies.estimation.innovations import LIMIT

JUMP_WINDOWS = 2
"""Windows in a row, not explained, that show a jump of numbers."""
BEGIN = 10
"""Windows before the first alarm: numbers, and a motion that was not known, are still being found."""
_ALLOWED = 1.3
"""Squared innovation over its variance, a sample, up to which nothing is summed up; of right models it was 0.8 to 1.3
over 20 windows (evidence/docs/estimator.md)."""
_AFTER_EXPLAINED, _MOST = 4.0, 10.0
"""Largest share that a window can add, a sample: a window after an explained window, as a spike makes it; and any other
window. In the first `BEGIN` windows only what is above the first of the two is summed up, and nothing is taken away:
few members with wide numbers do not tell how odd a window may be. Windows of right models added up to 3.5."""
_DOUBT = 100.0
"""Sum from which the model is doubted. It is reached by chance at a time in exp(-0.2 * 100), two in 10^9: 0.2 is the
root of E[exp(a (x - 1.3))] = 1 for chi-square x (Siegmund 1985)."""
_RISEN = 0.25
"""Part of `_DOUBT` that a right model passes in exp(-0.2 * 25), 0.7 % of the time: from there on the sum has risen."""
_LARGEST_SUM = 300.0
"""Largest sum. A model that is right again takes 0.3 away a sample, so it is believed after 100 windows of ten."""
_KNOWN = 0.1
"""Misfit of the first window over the channel's largest value after `BEGIN`, up to which the motion was known at the
start: from rest it is the error of the sensor; a rig in motion differs by as much as it moves."""
_MOST_SPANS = 100
"""Last spans that are kept."""


class Span(NamedTuple):
    """Windows in a row with an alarm: start of the first, end of the last [s], and their number."""

    start: float
    end: float
    windows: int


class Doubts:
    """Doubts in C channels, window by window.

    Attributes:
        since: Time since which each channel is not explained [s], by name.
        spans: Windows with an alarm so far, the last ones.
    """

    def __init__(self, channels: Sequence[str]) -> None:
        self._channels, self._windows = list(channels), 0
        self._sums: Array = np.zeros(len(channels))
        self._earlier: deque[Array] = deque([self._sums], maxlen=JUMP_WINDOWS + 1)  # sums after the last windows
        self._first: Array = np.full(len(channels), np.nan)
        self._off: Array = np.zeros(len(channels))  # of the first window
        self._before: Array = np.zeros(len(channels))  # squared innovation a sample, of the last window
        self.since: Mapping[str, float] = {}
        self.spans: tuple[Span, ...] = ()

    def take(self, start: float, surprises: Array, samples: Array, off: Array, scale: Array) -> None:
        """Take a window; all arrays have the shape (C,).

        Args:
            start: First time of the window [s].
            surprises: Squared innovation over its covariance, summed over the samples.
            samples: Number of the samples.
            off: Rms innovation [SI]; NaN where nothing was measured.
            scale: Largest size of the channel [SI].
        """
        self._windows += 1
        if self._windows == 1:
            self._off = off
        each = surprises / np.maximum(samples, 1)
        counted = np.minimum(each, np.clip(self._before, _AFTER_EXPLAINED, _MOST))
        gain = samples * (counted - _ALLOWED if self._windows > BEGIN else np.maximum(counted - _AFTER_EXPLAINED, 0.0))
        self._before = np.where(samples > 0, each, self._before)
        self._first = np.where((self._sums <= _RISEN * _DOUBT) & (gain > 0.0), start, self._first)
        self._sums = np.clip(self._sums + gain, 0.0, _LARGEST_SUM)
        if self._windows == BEGIN and not np.all(self._off <= _KNOWN * scale):
            self._sums = np.zeros_like(self._sums)
        self._earlier.append(self._sums)
        self._judge()

    def forget(self) -> None:
        """Forget the windows of a jump, which numbers that have changed explain, or a motion that was lost."""
        self._sums = self._earlier[0]
        self._judge()

    def _judge(self) -> None:
        self.since = {
            name: float(first)
            for name, total, first in zip(self._channels, self._sums, self._first, strict=True)
            if self._windows > BEGIN and (total > _DOUBT or (name in self.since and total > 0.0))
        }

    def remember(self, start: float, end: float) -> None:
        """Take a window at whose end an alarm stands."""
        *earlier, last = self.spans or (Span(start, start, 0),)
        if last.end < start:
            earlier, last = [*earlier, last], Span(start, start, 0)
        self.spans = (*earlier, Span(last.start, end, last.windows + 1))[-_MOST_SPANS:]


def told_of_spans(spans: Sequence[Span], shown: int = 3) -> str:
    """Sentence on windows with an alarm, of which the last spans are named; empty without."""
    named = ", ".join(f"from {one.start:.1f} to {one.end:.1f} s ({one.windows} windows)" for one in spans[-shown:])
    more = f", and {len(spans) - shown} times before" * (len(spans) > shown)
    return f"an alarm stood {named}{more}" if spans else ""


_HOLDING, _APART, _MOST_APART = 10, 20, 80
"""Windows after a jump in which only the numbers that explain it are corrected, and windows before the next jump: a
motion that has lost its phase with the load is no jump of friction. Where no number explains a large jump, all numbers
are held until the next one, and the time to the next one doubles, as restarts cost some windows of computing."""
_TELLS = 0.5
"""Share of the variance of a number that a channel explains, from which the channel tells the number; not measured."""
_FADING = 0.97
"""Part of the share that is kept from window to window: a torque tells friction once in a cycle of stick-slip."""
_DIRECTIONS, _LEAST = 5, 0.01
"""Most directions of a channel that explain a number, and their least variance over the stated error's variance; not
measured."""

UNEXPLAINED = "none of the numbers"
"""Key of a jump that no number explains."""


class Jumps:
    """Detector of jumps over windows of C channels, for d numbers.

    Attributes:
        since: Time of the jump [s] by key of each number that explains it, for `_APART` windows; by `UNEXPLAINED`, if
            no number explains it.
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
        """Numbers that may be corrected, shape (d,): after a jump only the numbers that explain it; else all (True)."""
        if UNEXPLAINED not in self.since and (not self.since or self._wait < _APART - _HOLDING):
            return True
        return np.array([key in self.since for key in self._keys])

    def take(self, predicted: Array, numbers: Array, stated: Array, normalised: Array) -> Mask:
        """Take a window before its correction; returns the numbers that may explain a jump, shape (d,).

        Args:
            predicted: Channels of the members, shape (N, C, S).
            numbers: Numbers of the members, shape (N, d).
            stated: Stated errors of a sample, shape (C,).
            normalised: Rms innovation of each channel over the predicted one, shape (C,); NaN where not measured.
        """
        told = np.array([explained(predicted[:, k] / error, numbers) for k, error in enumerate(stated)])
        self._told = np.maximum(_FADING * self._told, told)
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
        """Take the numbers that explain the last windows.

        Args:
            start: First time of the window that showed the jump [s].
            chosen: Numbers that have jumped, shape (d,), none of them where the motion was lost; None if nothing
                explains the windows.
        """
        wait = _APART
        if chosen is not None:
            self.since = {key: start for key, is_chosen in zip(self._keys, chosen, strict=True) if is_chosen}
        else:
            wait = min(2 * self._apart, _MOST_APART) if UNEXPLAINED in self.since else _APART
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
        return f"a jump at {since[UNEXPLAINED]:.1f} s that {UNEXPLAINED} explains: numbers are held"
    parts = [f"{key} since {time:.1f} s" for key, time in since.items()]
    return f"looked for anew after a jump: {', '.join(parts)}" if parts else ""
