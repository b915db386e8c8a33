# SPDX-License-Identifier: Apache-2.0
"""Plays a bag into the page: at a rate, from a time, stopped and on again."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from drill_twin.errors import DrillTwinError
from drill_twin.io.bag.reader import Bag
from drill_twin.io.messages.stamps import unpack_stamp
from drill_twin.io.messages.topics import STRING_POSES, TWIN_SCENE, WHIRL_ONSET
from drill_twin.live.feed import INPUTS, Feed

Message = tuple[str, int, bytes]
"""Topic, time [ns], CDR."""

_MOMENT = 0.02  # s
_STAMPED = 12  # bytes
_HIGHEST_RATE = 64.0


def in_simulated_time(messages: Iterable[Message]) -> Iterator[Message]:
    """Messages with the simulated time [ns] of the frame they follow instead of that of their recording.

    A run in lockstep, or as fast as possible, was recorded in no time; a paused one stood still. Where simulated time
    goes back, as after a reset, it goes on from where it was. Ahead of the first frame its own time counts, and in a
    bag without frames that of the recording.
    """
    early: list[Message] = []
    last, back = None, 0
    for topic, recorded, raw in messages:
        if topic == STRING_POSES and len(raw) >= _STAMPED:
            stamp = unpack_stamp(raw)
            if last is None:
                yield from ((name, stamp, content) for name, _, content in early)
                early.clear()
            else:
                back += max(last - stamp, 0)
            last = stamp
        if last is None:
            early.append((topic, recorded, raw))
        else:
            yield topic, last + back, raw
    yield from early


class Player:
    """A bag as a run that happens again, with a hand on its time."""

    def __init__(self, path: Path) -> None:
        """Open a bag.

        Raises:
            BagError: It is none.
        """
        bag = Bag(path)
        self._messages = list(in_simulated_time(bag.messages(INPUTS)))
        # From the first frame on: before it, the nodes waited for each other.
        self._start = next((stamp for topic, stamp, _ in self._messages if topic == STRING_POSES), bag.start)
        self.length = ((self._messages[-1][1] if self._messages else bag.end) - self._start) * 1e-9
        """Length of the recording [s]."""
        self.feed = Feed()
        self._lock = threading.Lock()
        self._at, self._next, self._rate, self._playing, self._over = 0.0, 0, 1.0, True, False
        self._thread = threading.Thread(target=self._play, name="player", daemon=True)
        self._thread.start()

    def picture(self) -> Mapping[str, Any]:
        """What the page shows."""
        player = {"at": min(self._at, self.length), "length": self.length, "playing": self._playing}
        return {**self.feed.picture(), "player": player}

    def asked(self, request: Mapping[str, Any]) -> None:
        """Play, stop, go to a time [s], or change the rate.

        Raises:
            DrillTwinError: It is none of these.
        """
        unknown = set(request) - {"play", "seek", "rate"}
        if unknown:
            raise DrillTwinError(f"expected play, seek or rate for a recording, found {', '.join(sorted(unknown))}")
        with self._lock:
            if "play" in request:
                self._playing = bool(request["play"])
                if self._playing and self._at >= self.length:
                    self._go_to(0.0)
            if "rate" in request:
                self._rate = min(max(float(request["rate"]), 0.0), _HIGHEST_RATE)
            if "seek" in request:
                self._go_to(min(max(float(request["seek"]), 0.0), self.length))

    def close(self) -> None:
        """Stop playing."""
        self._over = True
        self._thread.join(5.0)

    def _go_to(self, at: float) -> None:
        """Show what held then: the scene and the onset from before, all else from the second before."""
        self._at = at
        place = self._start + round(at * 1e9)
        self.feed.forget()
        begin = next((k for k, message in enumerate(self._messages) if message[1] > place - 10**9), 0)
        for topic in (TWIN_SCENE, WHIRL_ONSET):
            before = [raw for name, stamp, raw in self._messages if name == topic and stamp <= place]
            if before:
                self.feed.take(topic, before[-1])
        self._next = begin

    def _play(self) -> None:
        last = time.monotonic()
        while not self._over:
            time.sleep(_MOMENT)
            now = time.monotonic()
            with self._lock:
                if self._playing:
                    self._at += (now - last) * self._rate
                place = self._start + round(self._at * 1e9)
                while self._next < len(self._messages) and self._messages[self._next][1] <= place:
                    topic, _, raw = self._messages[self._next]
                    self.feed.take(topic, raw)
                    self._next += 1
                if self._at >= self.length:
                    self._at, self._playing = self.length, False
            last = now
