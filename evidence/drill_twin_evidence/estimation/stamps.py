# SPDX-License-Identifier: Apache-2.0
"""Stamps of a record: no clock of a rig lies on the grid of the estimator, and samples are lost on the way."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from drill_twin.core.arrays import Array


@dataclass(frozen=True)
class Stamps:
    """Sampling and stamps of a record.

    Attributes:
        rate: Samples a second [Hz].
        offset: Stamp of the first sample after a time from sample to sample [s]; None: drawn, up to that time.
        drift: Error of the clock, relative; None: drawn, up to 1e-4 either way.
        jitter: Largest error of a single stamp [s], drawn evenly.
        lost: Share of the samples that are lost.
        instant: Whether samples are values at their times, and not means since the last.
    """

    rate: float = 10.0
    offset: float | None = None
    drift: float | None = None
    jitter: float = 2e-3
    lost: float = 0.03
    instant: bool = False

    def drawn(self, seed: int) -> SampledRecord:
        """Record of a truth."""
        return SampledRecord(self, np.random.default_rng([seed, 5]))


USUAL = Stamps()
"""Stamps of the score: 10 Hz, offset and drift drawn, 2 ms of jitter, 3 % lost."""


class SampledRecord:
    """Samples of a signal that comes frame by frame.

    Attributes:
        clock: Time of the stamps over true time.
    """

    def __init__(self, stamps: Stamps, draw: np.random.Generator) -> None:
        self._of, self._draw = stamps, draw
        self._spacing = 1.0 / stamps.rate
        drift = draw.uniform(-1e-4, 1e-4) if stamps.drift is None else stamps.drift
        self.clock = 1.0 + drift
        self._offset = draw.uniform(0.0, self._spacing) if stamps.offset is None else stamps.offset
        self._times: Array = np.zeros(1)  # ends of the frames, true
        self._sums: dict[str, Array] = {}  # integral of each channel up to these
        self._next = 0  # sample
        self._waiting: deque[tuple[float, Mapping[str, float]]] = deque()

    def add(self, frames: Mapping[str, Array], period: float) -> None:
        """Add frames of each channel, shape (F,), of a length [s]."""
        for name, values in frames.items():
            old = self._sums.get(name, np.zeros(1))
            self._sums[name] = np.append(old, old[-1] + np.cumsum(values) * period)
        size = next(iter(frames.values())).size
        self._times = np.append(self._times, self._times[-1] + period * np.arange(1.0, size + 1.0))
        while (end := (self._offset + self._next * self._spacing) / self.clock) <= self._times[-1]:
            length = period if self._of.instant else self._spacing / self.clock
            stamp = end * self.clock + self._of.jitter * self._draw.uniform(-1.0, 1.0)
            if end - length >= 0.0 and stamp > 0.0 and self._draw.uniform() >= self._of.lost:
                places = np.array([end - length, end])
                means = {
                    name: float(np.diff(np.interp(places, self._times, values))[0]) / length
                    for name, values in self._sums.items()
                }
                self._waiting.append((stamp, means))
            self._next += 1

    def samples(self) -> Iterator[tuple[float, Mapping[str, float]]]:
        """Stamps [s] and values by name of the samples that have come."""
        while self._waiting:
            yield self._waiting.popleft()
