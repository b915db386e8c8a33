# SPDX-License-Identifier: Apache-2.0
"""Playback of a bag on the live page, in simulated time."""

import threading
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from drill_twin.core.errors import DrillTwinError, MessageError
from drill_twin.io.bag.reader import Bag
from drill_twin.io.bag.skipped import stray_stamps
from drill_twin.io.messages.decode import read_pose_array
from drill_twin.io.messages.topics import STRING_POSES, TWIN_SCENE, WHIRL_ONSET
from drill_twin.io.messages.whirl_encode import decode_onset
from drill_twin_dashboard.live.page_state import INPUTS, PageState

Message = tuple[str, int, bytes]
"""Topic, time [ns], CDR."""

_PERIOD = 0.02  # s, between two updates
_HIGHEST_RATE = 64.0
_LEAD = 1.0
"""Time played before the onset [s]."""


def in_simulated_time(messages: Iterable[Message]) -> Iterator[Message]:
    """Messages with the simulated time [ns] of the frame they follow in place of their time of recording.

    The time of recording says little: a run in lockstep or at full speed is recorded faster than simulated time, and a
    paused run slower. Where simulated time steps back, as after a reset, the result continues from where it was.
    Messages before the first frame get its time; messages of a bag without frames keep their time of recording. Frames
    that are damaged or have a stamp from the future give no time.
    """
    early: list[Message] = []
    last, back = None, 0
    messages = list(messages)
    stamps = _frame_stamps(messages)
    for place, (topic, recorded, raw) in enumerate(messages):
        stamp = stamps.get(place)
        if stamp is not None:
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


def _frame_stamps(messages: Sequence[Message]) -> dict[int, int]:
    """Stamps [ns] of the frames by place among the messages."""
    stamps = {}
    for place, (topic, _, raw) in enumerate(messages):
        if topic == STRING_POSES:
            with suppress(MessageError):  # the page counts it
                stamps[place] = read_pose_array(raw).stamp
    stray = stray_stamps(list(stamps.values()))
    return {place: stamp for k, (place, stamp) in enumerate(stamps.items()) if k not in stray}


class Player:
    """Seekable playback of a bag, in a thread of its own; a page that opens starts it shortly before the onset."""

    def __init__(self, path: Path, namespace: str | None = None) -> None:
        """Open a bag.

        Args:
            path: Bag folder or file.
            namespace: Namespace of the twin; None: the only one.

        Raises:
            BagError: The path is not a bag.
        """
        bag = Bag(path, namespace=namespace)
        self.damage = bag.damage
        """Sentences on missing or damaged parts of the bag."""
        self._messages = list(in_simulated_time(bag.messages(INPUTS)))
        # Playback starts at the first frame: before it, the nodes waited for each other.
        self._start = next((stamp for topic, stamp, _ in self._messages if topic == STRING_POSES), bag.start)
        self.length = ((self._messages[-1][1] if self._messages else bag.end) - self._start) * 1e-9
        """Length of the recording [s]."""
        self.state = PageState()
        self.state.fill_trends((topic, raw) for topic, _, raw in self._messages)
        self._lock = threading.Lock()
        self._at, self._next, self._rate, self._playing, self._closed = 0.0, 0, 1.0, False, False
        self.beginning = self._beginning()
        """Time at which a page begins to play [s]: shortly before the onset; 0 where there is none."""
        self._seek(self.beginning)
        self._thread = threading.Thread(target=self._play, name="player", daemon=True)
        self._thread.start()

    def snapshot(self) -> Mapping[str, Any]:
        """State of the page and of the playback."""
        player = {
            "at": min(self._at, self.length),
            "begin": self.beginning,
            "length": self.length,
            "playing": self._playing,
        }
        return {**self.state.snapshot(), "player": player}

    def on_request(self, request: Mapping[str, Any]) -> None:
        """Play or pause, seek to a time [s], or set the rate, as the page requests.

        Raises:
            DrillTwinError: Another request.
        """
        request = self.state.take(request)
        unknown = set(request) - {"play", "seek", "rate"}
        if unknown:
            raise DrillTwinError(f"expected play, seek or rate of a bag, found {', '.join(sorted(unknown))}")
        with self._lock:
            if "play" in request:
                self._playing = bool(request["play"])
                if self._playing and self._at >= self.length:
                    self._seek(0.0)
            if "rate" in request:
                self._rate = min(max(float(request["rate"]), 0.0), _HIGHEST_RATE)
            if "seek" in request:
                self._seek(min(max(float(request["seek"]), 0.0), self.length))

    def close(self) -> None:
        """End the playback."""
        self._closed = True
        self._thread.join(5.0)

    def _beginning(self) -> float:
        times = [0.0]
        for topic, stamp, raw in self._messages:
            if topic == WHIRL_ONSET:
                with suppress(MessageError):
                    at, onset = decode_onset(raw)
                    if onset is not None:
                        # The message follows the onset by the time that its detection took.
                        times.append((stamp - self._start - at) * 1e-9 + onset.time)
        return min(max(times[-1] - _LEAD, 0.0), self.length)

    def _seek(self, at: float) -> None:
        """Seek to a time [s]: restore scene and onset, and play the second before it at once."""
        self._at = at
        place = self._start + round(at * 1e9)
        self.state.clear()
        begin = next((k for k, message in enumerate(self._messages) if message[1] > place - 10**9), 0)
        for topic in (TWIN_SCENE, WHIRL_ONSET):
            earlier = [raw for name, stamp, raw in self._messages if name == topic and stamp <= place]
            if earlier:
                self.state.update(topic, earlier[-1])
        self._next = begin

    def _play(self) -> None:
        last = time.monotonic()
        while not self._closed:
            time.sleep(_PERIOD)
            now = time.monotonic()
            with self._lock:
                if self._playing:
                    self._at += (now - last) * self._rate
                place = self._start + round(self._at * 1e9)
                while self._next < len(self._messages) and self._messages[self._next][1] <= place:
                    topic, _, raw = self._messages[self._next]
                    self.state.update(topic, raw)
                    self._next += 1
                if self._at >= self.length:
                    self._at, self._playing = self.length, False
            last = now
