# SPDX-License-Identifier: Apache-2.0
"""Queues of a node: how many messages waited, how many were dropped unread, and scenes that take long to read."""

import time
from collections import Counter
from collections.abc import Callable, Mapping
from typing import Any

_CHEAP = 0.05  # s; an ordinary scene takes less, and is never put off
_SHARE = 0.1  # of a node's time, for scenes that take longer


class DropCounter:
    """Counts gaps in the sequence numbers of a publisher: a gap is a message that was dropped unread.

    Numbers of two publishers on one topic cannot be told apart, so gaps count only where there is one, and not in a
    second in which the numbers went back: another publisher has come or gone.
    """

    def __init__(self) -> None:
        self.dropped: Counter[str] = Counter()
        """Messages that were dropped, by topic."""
        self._waited = self._longest = 0
        self._first_taken = 0  # ns
        self._last: dict[str, int] = {}
        self._gaps: Counter[str] = Counter()
        self._went_back: set[str] = set()

    def take(self, topic: str, info: Mapping[str, Any]) -> None:
        """Note the times of a message that was taken and, unless the topic is empty, its number.

        A smaller number than before is from a new publisher.
        """
        if info["received_timestamp"] > self._first_taken:
            self._waited, self._first_taken = 0, time.time_ns()
        self._waited += 1  # messages that were waiting when the first of them was taken
        self._longest = max(self._longest, self._waited)
        number = info["publication_sequence_number"]
        if not topic or number is None:
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


class SceneGate:
    """Passes scenes on; after a scene that took long, only the newest of the scenes that have come since.

    A flood of large texts must not keep a node from its frames.
    """

    def __init__(self, process: Callable[[bytes], object], clock: Callable[[], float] = time.monotonic) -> None:
        """Pass scenes on to a function.

        Args:
            process: Parses and uses a scene in CDR.
            clock: Monotonic time [s].
        """
        self._process, self._clock = process, clock
        self._due, self._loaded = 0.0, False  # with the first scene modules and compiled code are loaded
        self._waiting: bytes | None = None
        self.put_off = 0
        """Scenes that were replaced by a newer one before their turn."""

    @property
    def waits(self) -> bool:
        """True while a scene waits for its turn."""
        return self._waiting is not None

    def take(self, raw: bytes) -> None:
        """Take a scene that has arrived."""
        self.put_off += self.waits
        self._waiting = raw
        self.work()

    def work(self) -> None:
        """Pass on the scene that waits, if its turn has come."""
        begun = self._clock()
        if self._waiting is None or begun < self._due:
            return
        raw, self._waiting = self._waiting, None
        self._process(raw)
        now, first, self._loaded = self._clock(), not self._loaded, True
        if now - begun > _CHEAP and not first:
            self._due = now + (now - begun) / _SHARE
