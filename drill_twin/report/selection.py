# SPDX-License-Identifier: Apache-2.0
"""Selection of what is analysed in a bag: marks, time, names of topics; marks of a bag without a scene."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

from drill_twin.core.errors import BagError, MessageError
from drill_twin.io.bag.reader import Bag
from drill_twin.io.bag.record import RecordBag, is_record
from drill_twin.io.messages.decode import JointStateReader
from drill_twin.io.messages.topics import MARKS_STATE, MEASURED, RIG_STATE, sub_of
from drill_twin.whirl import MarkInfo


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
    rim: float = 0.0
    """Outer radius of the string at the marks [m], for a bag without a scene; 0 for marks on the centre line."""
    sub: str = ""
    """Downhole sub whose readings are analysed instead of the marks; empty: the one with most readings in a bag without
    marks."""

    def __post_init__(self) -> None:
        """Refuse a time that holds nothing.

        Raises:
            BagError: The end is not after the start, or one of them is not a number.
        """
        if not self.begin < self.end:
            raise BagError(f"--from, --to: expected a start before the end, found {self.begin:g} s and {self.end:g} s")

    @property
    def whole(self) -> bool:
        """True if all marks and times are analysed, as by the live analyzer."""
        return not self.marks and self.begin == -math.inf and self.end == math.inf

    def holds(self, stamp: int) -> bool:
        """True if a header stamp [ns] is within the selected time."""
        return self.begin <= stamp * 1e-9 <= self.end


def open_bag(path: Path, selection: Selection) -> Bag:
    """Bag at a path, its topics under the names of the contract; or the record of a rig, as a bag.

    Raises:
        BagError: It is not a bag, or lacks a topic of the selection.
        TableError: The record cannot be read.
    """
    if is_record(path):
        return RecordBag(path)
    window = (
        (selection.begin, selection.end) if math.isfinite(selection.begin) or math.isfinite(selection.end) else None
    )
    return Bag(path, names=selection.topics, namespace=selection.namespace, window=window)


def missing_topics(bag: Bag) -> list[str]:
    """Topics of marks and rig that have no messages."""
    return [topic for topic in (MARKS_STATE, RIG_STATE) if topic not in bag.topics or not bag.topics[topic].count]


def sub_without_marks(bag: Bag) -> str:
    """Name of the downhole sub with most readings, `measured/NAME` for that of a real rig; empty without one."""
    counts = {name: topic.count for name, topic in bag.topics.items() if sub_of(name) and name.endswith("/imu")}
    topic = max(counts, key=lambda name: (counts[name], name.startswith(MEASURED)), default="")
    return f"{'measured/' if topic.startswith(MEASURED) else ''}{sub_of(topic)}" if topic and counts[topic] else ""


def marks_without_scene(bag: Bag, selection: Selection) -> Sequence[MarkInfo]:
    """Marks of a bag without a scene, from the names of the joints in most messages; empty without a clearance.

    Raises:
        AnalysisError: The clearance or the rim is not a valid length.
    """
    if selection.clearance is None:
        return ()
    reader, layouts = JointStateReader(), Counter[tuple[str, ...]]()
    for _, _, raw in bag.messages((MARKS_STATE,)):
        with suppress(MessageError):  # the recording counts it
            layouts[reader.read(raw).names] += 1
    names = layouts.most_common(1)[0][0] if layouts else ()
    marks = [name.removesuffix("/x") for name in names if name.endswith("/x")]
    on = "wall" if selection.rim else "centre"
    return [
        MarkInfo(mark, float(k), on, selection.rim, selection.clearance)  # type: ignore[arg-type]
        for k, mark in enumerate(marks)
    ]
