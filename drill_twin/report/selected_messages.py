# SPDX-License-Identifier: Apache-2.0
"""Messages of a bag in the selected time, without stray stamps, many at once; sentences where they hold nothing."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

from drill_twin.io.bag.reader import Bag
from drill_twin.io.bag.skipped import SkippedMessages, stray_stamps
from drill_twin.io.downhole import readings_topic
from drill_twin.io.messages.stamps import raw_header_stamp, seconds
from drill_twin.io.messages.topics import (
    MARKS_STATE,
    RIG_COMMAND,
    RIG_STATE,
    STRING_POSES,
    STRING_STRESS,
    TWIN_SCENE,
    WHIRL_STATE,
)
from drill_twin.report.selection import Selection
from drill_twin.whirl.downhole import WAITING

_FIRST_BATCH, _BATCH, _BATCH_BYTES = 64, 4096, 8_000_000
"""Messages that are read at once, first, and then; and their size."""
_WITH_HEADER = frozenset({MARKS_STATE, RIG_STATE, RIG_COMMAND, STRING_POSES, STRING_STRESS, WHIRL_STATE})
"""Topics whose messages begin with a header, so that they can be selected by time."""

Message = tuple[str, bytes, float]
"""Topic, CDR, and the time of it or of the last message before it that has one [s]."""


class SelectedMessages:
    """Reads the selected messages of a bag, as often as asked."""

    def __init__(self, bag: Bag, selection: Selection, with_header: set[str]) -> None:
        """Read the stamps of all messages.

        Args:
            bag: The bag.
            selection: The part of it that is read.
            with_header: Topics whose messages begin with a header, besides those of the contract.
        """
        self._bag, self._selection = bag, selection
        self._with_header = _WITH_HEADER | with_header
        stamps: dict[str, list[int]] = {}
        for topic, _, raw in bag.messages(self._with_header):
            stamps.setdefault(topic, []).append(raw_header_stamp(raw))
        self.poses = sum(map(selection.holds, stamps.get(STRING_POSES, ())))
        """Number of poses of the string in the selected time."""
        self._stray = {topic: stray_stamps(values) for topic, values in stamps.items()}

    def read(self, topics: tuple[str, ...], skipped: SkippedMessages) -> Iterator[Message]:
        """Selected messages in order; those with a stamp from the future are skipped."""
        places, time = dict.fromkeys(self._stray, -1), 0.0
        for topic, _, raw in self._bag.messages(topics):
            if topic in self._with_header:
                stamp = raw_header_stamp(raw)
                places[topic] += 1
                if places[topic] in self._stray[topic]:
                    reason = f"expected a stamp near those of the messages around it, found {seconds(stamp):g} s"
                    skipped.add(topic, time, reason)
                    continue
                if not self._selection.holds(stamp):
                    continue
                time = seconds(stamp) or time
            yield topic, raw, time

    def batches(self, topics: tuple[str, ...], skipped: SkippedMessages) -> Iterator[list[Message]]:
        """The same in lists, which end where marks and rig states are paired, if they do."""
        batch: list[Message] = []
        unpaired, size, least = 0, 0, _FIRST_BATCH
        for message in self.read(topics, skipped):
            topic, raw, _ = message
            batch.append(message)
            unpaired += (topic == MARKS_STATE) - (topic == RIG_STATE)
            size += len(raw)
            filled = max(len(batch) / least, size / _BATCH_BYTES)
            if filled >= 2.0 or (filled >= 1.0 and unpaired == 0):
                yield batch
                batch, size, least = [], 0, _BATCH
        yield batch


def no_scene(path: Path, trouble: str, *, of_sub: bool) -> str:
    """Sentence on a bag without a usable scene.

    Args:
        path: Path of the bag.
        trouble: Reason why its scene cannot be used; empty without one.
        of_sub: The trouble is one with the readings of a sub.
    """
    if trouble:
        unused = "" if of_sub else f"expected a scene on {TWIN_SCENE}, found one that cannot be used: "
        return f"{path}: {unused}{trouble}"
    return (
        f"{path}: expected the scene on {TWIN_SCENE}, found no message there; "
        "name the scene with --scene, or give --clearance"
    )


def no_samples(bag: Bag, selection: Selection, sub: str, trouble: str) -> str:
    """Sentence on a bag, or a part of it, in which nothing can be analysed; `trouble` is the last reason for that."""
    needed = (readings_topic(sub),) if sub else (MARKS_STATE, RIG_STATE)
    counts = ", ".join(f"{bag.topics[one].count if one in bag.topics else 0} on {one}" for one in needed)
    why = f" ({trouble})" if trouble else ""
    if (selection.begin, selection.end) != (-math.inf, math.inf):
        why += f", none of them from {selection.begin:g} s to {selection.end:g} s; choose another --from and --to"
    wanted = f"readings of {sub}" if sub else "marks and rig states with the same stamps"
    return f"{bag.path}: expected {wanted} to analyse, found {counts}{why}"


def no_rotation(path: Path, sub: str) -> str:
    """Sentence on a bag whose samples do not tell the rotation, without which whirl is not defined."""
    if sub:
        return f"{path}: expected revolutions of a sub at a steady speed, found {WAITING}"
    return (
        f"{path}: expected the rotation, as top_drive on {RIG_STATE} or as the spin of the marks, "
        "found neither; without rotation whirl is not defined"
    )
