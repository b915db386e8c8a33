# SPDX-License-Identifier: Apache-2.0
"""Bounded work for the scenes that arrive: a flood of large texts must not keep a node from its frames."""

from __future__ import annotations

import time
from collections.abc import Callable

_CHEAP = 0.05  # s; an ordinary scene takes less, and is never put off
_SHARE = 0.1  # of a node's time for scenes that take longer


class SceneGate:
    """Passes scenes on at once, or after one that took long the newest of those that came meanwhile."""

    def __init__(self, process: Callable[[bytes], None], clock: Callable[[], float] = time.monotonic) -> None:
        """Pass scenes on to a function.

        Args:
            process: Parses and uses a scene in CDR.
            clock: Monotonic time [s].
        """
        self._process, self._clock = process, clock
        self._due = 0.0
        self._waiting: bytes | None = None
        self.put_off = 0
        """Scenes that were replaced by a newer one before their turn."""

    def take(self, raw: bytes) -> None:
        """Take a scene that has arrived."""
        self.put_off += self._waiting is not None
        self._waiting = raw
        self.work()

    def work(self) -> None:
        """Pass on the scene that waits, if its turn has come."""
        begun = self._clock()
        if self._waiting is None or begun < self._due:
            return
        raw, self._waiting = self._waiting, None
        self._process(raw)
        now = self._clock()
        if now - begun > _CHEAP:
            self._due = now + (now - begun) / _SHARE
