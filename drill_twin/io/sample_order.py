# SPDX-License-Identifier: Apache-2.0
"""Order of the samples of a stream, and the recovery from one stamp of the future or a clock set back."""

from __future__ import annotations

from typing import Generic, Protocol, TypeVar

STUCK = 200
"""Number of ordered samples, all before the latest stamp, after which the analysis starts again; 1 to 2 s."""


class _Stamped(Protocol):
    @property
    def stamp(self) -> int: ...


Item = TypeVar("Item", bound=_Stamped)


class SampleOrder(Generic[Item]):
    """Finds `STUCK` ordered samples that are all before the latest stamp.

    Single late samples are rejected by the analyzer; but after one stamp from the future, or a clock set back, all
    samples would be rejected.

    Attributes:
        latest: Latest stamp so far [ns]; -1 before the first.
    """

    def __init__(self) -> None:
        self.latest = -1
        self._behind: list[Item] = []

    def take(self, sample: Item) -> list[Item]:
        """Note a sample; returns those with which the analysis is to start again, mostly none."""
        if sample.stamp >= self.latest:
            self.pass_by(sample.stamp)
            return []
        if self._behind and sample.stamp <= self._behind[-1].stamp:
            self._behind.clear()
        self._behind.append(sample)
        return list(self._behind) if len(self._behind) >= STUCK else []

    def pass_by(self, stamp: int) -> None:
        """Note ordered samples up to a stamp [ns], none of which is before the latest."""
        self.latest = stamp
        self._behind.clear()
