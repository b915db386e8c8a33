# SPDX-License-Identifier: Apache-2.0
"""Doubts in a model: what is measured differs from what members and noise allow, and goes on doing so.

The squared innovation of a window over its covariance, that of the members and of the noise of the record, is about
the number of its samples where the model is right, numbers not found yet included (Bar-Shalom, Li and Kirubarajan 2001,
section 5.4). What lies above it is summed up (Page 1954): a small misfit that lasts counts as a large one does, and a
model that was wrong is believed again only after it has been right for long. Until then its numbers may be bent.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array

JUMP_WINDOWS = 2
"""Windows in a row, not explained, that show a jump of numbers (`drill_twin_studies.estimation.jumps`)."""
BEGIN = 10
"""Windows before the first alarm: numbers, and a motion that was not known, are still being found."""
_ALLOWED = 1.3
"""Squared innovation over its variance, a sample, up to which nothing is summed up; of right models it was 0.8 to 1.3
over 20 windows (evidence/docs/estimator.md)."""
_ALONE, _MOST = 4.0, 10.0
"""The same of a window, beyond which it counts no more: of one after a window that is explained, as a spike makes it,
and of any. In the first `BEGIN` windows what is above the former is summed up, and nothing is taken away: few members
with wide numbers do not say what a window may be; of right models it was up to 3.5."""
_DOUBT = 100.0
"""Sum from which the model is doubted. It is reached by chance at a time in exp(-0.2 * 100), two in 10^9: 0.2 is the
root of E[exp(a (x - 1.3))] = 1 for chi-square x (Siegmund 1985)."""
_RISEN = 0.25
"""Part of it that a right model passes in exp(-0.2 * 25), 0.7 % of the time: where the sum began to rise from."""
_LONGEST = 300.0
"""Largest sum. A model that is right again takes 0.3 of it a sample, and is believed after 100 windows of ten."""
_KNOWN = 0.1
"""Misfit of the first window over the channel's largest value after `BEGIN`, up to which the motion was known at the
start: from rest it is the error of the sensor; a rig in motion differs by as much as it moves."""
_KEPT = 100
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
            start: Its first time [s].
            surprises: Squared innovation over its covariance, summed over the samples.
            samples: Number of the samples.
            off: Rms innovation [SI]; NaN where nothing was measured.
            scale: Largest size of the channel [SI].
        """
        self._windows += 1
        if self._windows == 1:
            self._off = off
        each = surprises / np.maximum(samples, 1)
        counted = np.minimum(each, np.clip(self._before, _ALONE, _MOST))
        gain = samples * (counted - _ALLOWED if self._windows > BEGIN else np.maximum(counted - _ALONE, 0.0))
        self._before = np.where(samples > 0, each, self._before)
        self._first = np.where((self._sums <= _RISEN * _DOUBT) & (gain > 0.0), start, self._first)
        self._sums = np.clip(self._sums + gain, 0.0, _LONGEST)
        if self._windows == BEGIN and not np.all(self._off <= _KNOWN * scale):
            self._sums = np.zeros_like(self._sums)
        self._earlier.append(self._sums)
        self._judge()

    def forget(self) -> None:
        """Forget the windows of a jump: numbers that have changed explain them, or a motion that was lost does."""
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
        self.spans = (*earlier, Span(last.start, end, last.windows + 1))[-_KEPT:]


def told_of_spans(spans: Sequence[Span], shown: int = 3) -> str:
    """Sentence on windows with an alarm, of which the last spans are named; empty without."""
    named = ", ".join(f"from {one.start:.1f} to {one.end:.1f} s ({one.windows} windows)" for one in spans[-shown:])
    more = f", and {len(spans) - shown} times before" * (len(spans) > shown)
    return f"an alarm stood {named}{more}" if spans else ""
