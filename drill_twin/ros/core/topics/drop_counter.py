# SPDX-License-Identifier: Apache-2.0
"""Fill of the queues of a node's subscriptions, and the messages that were dropped from them unread."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable


class DropCounter:
    """Counts gaps in the sequence numbers of a publisher: a gap is a message that was dropped unread.

    Numbers of two publishers on one topic cannot be told apart, so gaps count only where there is one, and not in a
    second in which the numbers went back: another publisher has come or gone.
    """

    def __init__(self) -> None:
        self.dropped: Counter[str] = Counter()
        """Messages that were dropped, by topic."""
        self._longest = 0
        self._last: dict[str, int] = {}
        self._gaps: Counter[str] = Counter()
        self._went_back: set[str] = set()

    def add_queue_length(self, count: int) -> None:
        """Note how many messages were waiting in one queue."""
        self._longest = max(self._longest, count)

    def add_sequence_number(self, topic: str, number: int | None) -> None:
        """Note the number of a message that was taken; a smaller one than before is from a new publisher."""
        if number is None:
            return
        missed = number - self._last.get(topic, number - 1) - 1
        if missed > 0:
            self._gaps[topic] += missed
        elif missed < 0:
            self._went_back.add(topic)
        self._last[topic] = number

    def confirm_gaps(self, publishers: Callable[[str], int]) -> None:
        """Count the gaps of topics that have one publisher; discard the others. Called about once a second."""
        for topic, missed in self._gaps.items():
            if publishers(topic) <= 1 and topic not in self._went_back:
                self.dropped[topic] += missed
        self._gaps.clear()
        self._went_back.clear()

    def values(self) -> dict[str, str]:
        """Values for the diagnostics: longest queue since the last report, and drops in all."""
        longest, self._longest = self._longest, 0
        return {"unread_most": str(longest), "dropped": str(self.dropped.total())}
