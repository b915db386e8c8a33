# SPDX-License-Identifier: Apache-2.0
"""Which part of a bag is analysed, under which topics, and what is known of its marks where no scene tells."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from drill_twin.errors import BagError, MessageError
from drill_twin.io.bag.mapped import MappedBag
from drill_twin.io.bag.reader import Bag
from drill_twin.io.messages.decode import JointStateReader
from drill_twin.io.messages.topics import MARKS_STATE, RIG_STATE
from drill_twin.whirl import MarkInfo


@dataclass(frozen=True)
class Selection:
    """What of a bag is analysed; by default all of it."""

    marks: tuple[str, ...] = ()
    """Names of marks; all where none."""
    begin: float = -math.inf
    """Samples before this stamp are left out [s]."""
    end: float = math.inf
    """Samples after this stamp are left out [s]."""
    topics: Mapping[str, str] = field(default_factory=dict)
    """Topics of the bag, and what they are called here."""
    clearance: float | None = None
    """Clearance of the marks [m], for a bag without a scene."""
    rim: float = 0.0
    """Outer radius of the string at the marks [m], for a bag without a scene; 0 for marks on the centre line."""

    @property
    def whole(self) -> bool:
        """Whether everything is analysed, as the live analyzer did."""
        return not self.marks and self.begin == -math.inf and self.end == math.inf

    def holds(self, stamp: int) -> bool:
        """Whether a header stamp [ns] is within the chosen time."""
        return self.begin <= stamp * 1e-9 <= self.end


def open_bag(path: Path, selection: Selection) -> Bag:
    """The bag at a path, its topics under our names.

    Raises:
        BagError: It is not a bag, or has not the topics that were named.
    """
    return MappedBag(path, selection.topics) if selection.topics else Bag(path)


def lacking(bag: Bag) -> list[str]:
    """Which of the topics that the analysis needs never came."""
    return [topic for topic in (MARKS_STATE, RIG_STATE) if topic not in bag.topics or not bag.topics[topic].count]


def described(bag: Bag, selection: Selection) -> Sequence[MarkInfo]:
    """The marks of a bag without a scene, by the names of its joints.

    Raises:
        BagError: Its marks cannot be read.
        AnalysisError: The clearance or the rim is no length.
    """
    if selection.clearance is None:
        return ()
    for _, _, raw in bag.messages((MARKS_STATE,)):
        try:
            names = JointStateReader().read(raw).names
        except MessageError as error:
            raise BagError(f"{bag.path}: {MARKS_STATE}: {error}") from error
        marks = [name.removesuffix("/x") for name in names if name.endswith("/x")]
        on = "wall" if selection.rim else "centre"
        return [
            MarkInfo(mark, float(k), on, selection.rim, selection.clearance)  # type: ignore[arg-type]
            for k, mark in enumerate(marks)
        ]
    return ()
