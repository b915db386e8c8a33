# SPDX-License-Identifier: Apache-2.0
"""Check for more than one publisher that sends on a topic.

DDS does not tell a Python subscriber who sent a message, but each publisher counts its own: the numbers of one only
grow, those of two that send in turn go back again and again. They go back once when a publisher was started anew.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable

_WINDOW = 5.0  # s
_TURNS = 2


class PublisherCheck:
    """Sequence numbers of the messages of one topic."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._last = -1
        self._turns: deque[float] = deque(maxlen=_TURNS)

    def take(self, number: int) -> bool:
        """Take the number of the next message; returns True where it is the first to show that several send."""
        before, back, self._last = self.several_send, number <= self._last, number
        if back:
            self._turns.append(self._clock())
        return back and not before and self.several_send

    @property
    def several_send(self) -> bool:
        """True while the numbers went back more than once in the last seconds."""
        return len(self._turns) == _TURNS and self._clock() - self._turns[0] < _WINDOW
