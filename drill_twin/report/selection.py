# SPDX-License-Identifier: Apache-2.0
"""Selection of what is analysed in a bag: marks, time, names of topics; marks of a bag without a scene.

Selected messages come without stray stamps, many at once; sentences tell where there are none.
"""

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Self

from drill_twin.core.errors import BagError, MessageError
from drill_twin.io.bag.reader import Bag
from drill_twin.io.bag.reading.files import bag_path
from drill_twin.io.bag.skipped import SkippedMessages, stray_stamps
from drill_twin.io.bag.virtual_bags import RecordBag, is_record
from drill_twin.io.messages.decode import JointStateReader
from drill_twin.io.messages.stamps import DATED, raw_header_stamp, seconds
from drill_twin.io.messages.topics import (
    MARKS_STATE,
    MEASURED,
    RIG_COMMAND,
    RIG_STATE,
    STRING_POSES,
    STRING_STRESS,
    TWIN_SCENE,
    WHIRL_STATE,
    sub_of,
)
from drill_twin.io.scene_geometry import readings_topic
from drill_twin.whirl import MarkInfo
from drill_twin.whirl.downhole import WAITING


@dataclass(frozen=True)
class Selection:
    """Part of a bag that is analysed; by default all."""

    marks: tuple[str, ...] = ()
    """Names of marks; all if empty."""
    begin: float = -math.inf
    """Earliest stamp [s]."""
    end: float = math.inf
    """Latest stamp [s]."""
    topics: Mapping[str, str] = field(default_factory=dict)
    """Names of the contract by the bag's names."""
    namespace: str | None = None
    """Namespace of the twin; None: the only one in the bag."""
    clearance: float | None = None
    """Clearance of the marks [m], for a bag without a scene."""
    outer_radius: float = 0.0
    """Outer radius of the string at the marks [m], for a bag without a scene; 0 for marks on the centre line."""
    sub: str = ""
    """Downhole sub whose readings are analysed instead of the marks; empty: the one with most readings in a bag without
    marks."""
    run: int = 0
    """Number of the run in a bag with several, from 1; 0: the last."""
    choices: tuple[str, ...] = ()
    """Columns of a record by channel, and its null values (`drill_twin.scene.records.read_columns`)."""
    units: str = ""
    """Units that people read (`drill_twin.core.units.system`); empty: the scene's."""

    def __post_init__(self) -> None:
        """Refuse a time that holds nothing.

        Raises:
            BagError: The end is not after the start, or start or end is not a number.
        """
        if not self.begin < self.end:
            raise BagError(f"--from, --to: expected a start before the end, found {self.begin:g} s and {self.end:g} s")

    @property
    def whole(self) -> bool:
        """True if all marks and times are analysed, as by the live analyzer."""
        return not self.marks and self.begin == -math.inf and self.end == math.inf

    @property
    def window(self) -> tuple[float, float] | None:
        """Start and end [s]; None where all times are selected."""
        ends = self.begin, self.end
        return ends if any(map(math.isfinite, ends)) else None

    def counted_from(self, origin: int) -> Self:
        """The selection with times from the start of the record [ns], where they are given as dates."""
        if not origin:
            return self
        begin, end = (at - seconds(origin) if at >= seconds(DATED) else at for at in (self.begin, self.end))
        return replace(self, begin=begin, end=end)

    def holds(self, stamp: int) -> bool:
        """True if a header stamp [ns] is within the selected time."""
        return self.begin <= stamp * 1e-9 <= self.end


def open_bag(path: str | Path, selection: Selection) -> Bag:
    """Bag at a path or in the folder of a run, its topics under the names of the contract; or the record of a rig.

    Raises:
        BagError: The path is not a bag, or the bag lacks a topic of the selection.
        TableError: The record cannot be read.
    """
    path = bag_path(path)
    if is_record(path):
        record = RecordBag(path, selection.choices)
        record.count_from_start()
        return record
    names, namespace = selection.topics, selection.namespace
    bag = Bag(path, names=names, namespace=namespace, window=selection.window)
    found = bag.count_from_start()
    if selection.window is not None and (bag.origin or not found):  # the window may be counted from the first stamp
        bag = Bag(path, names=names, namespace=namespace)
        bag.count_from_start()
    return bag


def missing_topics(bag: Bag) -> list[str]:
    """Topics of marks and rig that have no messages."""
    return [topic for topic in (MARKS_STATE, RIG_STATE) if topic not in bag.topics or not bag.topics[topic].count]


def sub_without_marks(bag: Bag) -> str:
    """Name of the downhole sub with most readings, `measured/NAME` for a sub of a real rig; empty without one."""
    counts = {name: topic.count for name, topic in bag.topics.items() if sub_of(name) and name.endswith("/imu")}
    topic = max(counts, key=lambda name: (counts[name], name.startswith(MEASURED)), default="")
    return f"{'measured/' if topic.startswith(MEASURED) else ''}{sub_of(topic)}" if topic and counts[topic] else ""


def marks_without_scene(bag: Bag, selection: Selection) -> Sequence[MarkInfo]:
    """Marks of a bag without a scene, from the names of the joints in most messages; empty without a clearance.

    Raises:
        AnalysisError: The clearance or the outer radius is not a valid length.
    """
    if selection.clearance is None:
        return ()
    reader, layouts = JointStateReader(), Counter[tuple[str, ...]]()
    for _, _, raw in bag.messages((MARKS_STATE,)):
        with suppress(MessageError):  # the recording counts it
            layouts[reader.read(raw).names] += 1
    names = layouts.most_common(1)[0][0] if layouts else ()
    marks = [name.removesuffix("/x") for name in names if name.endswith("/x")]
    on = "wall" if selection.outer_radius else "centre"
    return [
        MarkInfo(mark, float(k), on, selection.outer_radius, selection.clearance)  # type: ignore[arg-type]
        for k, mark in enumerate(marks)
    ]


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
            with_header: Topics whose messages begin with a header, besides the contract's topics.
        """
        self._bag, selection = bag, selection.counted_from(bag.origin)
        self._selection = selection
        self._with_header = _WITH_HEADER | with_header
        stamps: dict[str, list[int]] = {}
        for topic, _, raw in bag.messages(self._with_header):
            stamps.setdefault(topic, []).append(raw_header_stamp(raw))
        self.poses = sum(map(selection.holds, stamps.get(STRING_POSES, ())))
        """Number of poses of the string in the selected time."""
        self._stray = {topic: stray_stamps(values) for topic, values in stamps.items()}

    def read(self, topics: tuple[str, ...], skipped: SkippedMessages) -> Iterator[Message]:
        """Selected messages in order; a message with a stamp far from its neighbours' is skipped."""
        places, time = dict.fromkeys(self._stray, -1), 0.0
        for topic, _, raw in self._bag.messages(topics):
            if topic in self._with_header:
                stamp = raw_header_stamp(raw)
                places[topic] += 1
                if places[topic] in self._stray[topic]:
                    reason = f"expected a stamp near the stamps of the messages around it, found {seconds(stamp):g} s"
                    skipped.add(topic, time, reason)
                    continue
                if not self._selection.holds(stamp):
                    continue
                time = seconds(stamp) or time
            yield topic, raw, time

    def batches(self, topics: tuple[str, ...], skipped: SkippedMessages) -> Iterator[list[Message]]:
        """Selected messages in lists; a list ends where marks and rig states are paired, if they are anywhere."""
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
        of_sub: True if the trouble is with the readings of a sub.
    """
    if trouble:
        unused = "" if of_sub else f"expected a scene on {TWIN_SCENE}, found a scene that cannot be used: "
        return f"{path}: {unused}{trouble}"
    return (
        f"{path}: expected the scene on {TWIN_SCENE}, found no message there; "
        "name the scene with --scene, or give --clearance"
    )


def no_samples(bag: Bag, selection: Selection, sub: str, trouble: str) -> str:
    """Sentence on a bag, or a part of it, in which nothing can be analysed; `trouble` is the last reason."""
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
