# SPDX-License-Identifier: Apache-2.0
"""How full the queues of a node's subscriptions were, and what fell out of them unread."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable


class DropCounter:
    """Watches the numbers that a publisher gives its messages: a gap is a message that was dropped unread.

    Numbers of two publishers on one topic cannot be told apart, so gaps count only where there is one.
    """

    def __init__(self) -> None:
        self.dropped: Counter[str] = Counter()
        """Messages that were dropped, by topic."""
        self._deepest = 0
        self._last: dict[str, int] = {}
        self._gaps: Counter[str] = Counter()

    def took(self, count: int) -> None:
        """So many messages were waiting in one queue."""
        self._deepest = max(self._deepest, count)

    def number(self, topic: str, number: int | None) -> None:
        """The number of a message that was taken; a smaller one than before is a new publisher's."""
        if number is None:
            return
        if (missed := number - self._last.get(topic, number - 1) - 1) > 0:
            self._gaps[topic] += missed
        self._last[topic] = number

    def settle(self, publishers: Callable[[str], int]) -> None:
        """Believe the gaps of topics that have one publisher; forget the others. Call about once a second."""
        for topic, missed in self._gaps.items():
            if publishers(topic) <= 1:
                self.dropped[topic] += missed
        self._gaps.clear()

    def values(self) -> dict[str, str]:
        """For the diagnostics: the most that waited in one queue since the last report, and what was dropped in all."""
        deepest, self._deepest = self._deepest, 0
        return {"unread_most": str(deepest), "dropped": str(self.dropped.total())}
