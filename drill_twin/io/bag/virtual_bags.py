# SPDX-License-Identifier: Apache-2.0
"""Bags that are no files: messages of a run in memory, and the record of a rig as messages on `/rig/state`.

All that reads bags reads them too.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator
from contextlib import nullcontext, suppress
from dataclasses import replace
from pathlib import Path

import numpy as np

from drill_twin.core.errors import TableError
from drill_twin.core.rig_channels import ARRAYS, RECORDED, RIG_JOINTS, channel_of
from drill_twin.core.units import UnitError, parse
from drill_twin.core.units.dimension import FORCE
from drill_twin.core.units.parse import name_and_unit
from drill_twin.core.units.system import typed_in_pounds
from drill_twin.io.bag.metadata import RecordedTopic, contract_topic
from drill_twin.io.bag.reader import Bag
from drill_twin.io.bag.writer import BagWriter
from drill_twin.io.messages.cdr import JointStateTemplate
from drill_twin.io.messages.stamps import NANOSECONDS
from drill_twin.io.messages.topics import RIG_STATE
from drill_twin.scene.records import CHANNELS, RECORDS, read_columns
from drill_twin.scene.records.channels import BLOCK


class MemoryBag(Bag):
    """Messages of a run in memory, with the writing interface of `BagWriter` and the reading interface of `Bag`.

    Attributes:
        start: Time of the first message [ns].
        end: Time of the last message [ns].
    """

    def __init__(self, name: str = "memory") -> None:
        """Begin an empty bag.

        Args:
            name: Name in messages to the user, in place of a path.
        """
        self.path = Path(name)
        self.damage: list[str] = []
        self.topics: dict[str, RecordedTopic] = {}
        self.start = self.end = 0
        self._messages: list[tuple[str, int, bytes]] = []

    def write(self, topic: str, stamp: int, raw: bytes) -> None:
        """Record one message.

        Args:
            topic: Topic of the contract.
            stamp: Time of the recording [ns].
            raw: The message in CDR.
        """
        if topic not in self.topics:
            self.topics[topic] = contract_topic(topic)
        self.topics[topic].count += 1
        if not self._messages:
            self.start = stamp
        self.end = max(self.end, stamp)
        self._messages.append((topic, stamp, bytes(raw)))

    def write_all(self, messages: Iterable[tuple[str, int, bytes]]) -> None:
        """Record messages, each as `write`."""
        for message in messages:
            self.write(*message)

    def recorded_messages(self, topics: Collection[str] | None = None) -> Iterator[tuple[str, int, bytes]]:
        """As of `Bag`."""
        yield from (message for message in self._messages if topics is None or message[0] in topics)

    def snapshot(self) -> MemoryBag:
        """Copy that later writes do not change; the bytes of the messages are shared."""
        copy = MemoryBag(str(self.path))
        copy.start, copy.end = self.start, self.end
        copy.topics = {name: replace(topic) for name, topic in self.topics.items()}
        copy._messages = self._messages[:]
        return copy


def copy_bag(bag: Bag, folder: str | Path) -> Path:
    """Write all messages of a bag to a new bag folder.

    Returns:
        The folder.

    Raises:
        BagError: The folder exists or cannot be written, or the bag cannot be read.
    """
    with BagWriter(folder, topics=[replace(topic, count=0) for topic in bag.topics.values()]) as writer:
        for topic, stamp, raw in bag.recorded_messages():
            writer.write(topic, stamp, raw)
    return writer.folder


_SPEEDS = ("rotation", "bit_speed")
_LATEST = 2.0**31  # s, of a stamp
_AT_ONCE = 4096  # messages
_PLACES = {(channel.array, channel.joint): name for name in RECORDED for channel in [channel_of(name)]}
_JOINTS = [[_PLACES.get((array, joint), "") for joint in RIG_JOINTS] for array in ARRAYS]
"""Channels that are positions, velocities and efforts of the joints of a rig."""


def is_record(path: Path) -> bool:
    """True for a file with the ending of a CSV, MAT, LAS or WITSML record."""
    return path.suffix.lower() in RECORDS and not path.is_dir()


class RecordBag(Bag):
    """Bag of the channels of a record; channels that the record lacks are NaN. Messages are made as they are read.

    Attributes:
        read: The columns that were read and their units, for the user.
        columns: What is done with each column (`Columns.account`).
        chosen: Column and unit of channels that were chosen, by name.
        block: Weight of block and top drive in the hookload [N]; NaN where it is not given.
        notes: Sentences on what was left out, and on time and units.
        units: Units that people read: `field` where a force or torque is in pounds, else `si`.
    """

    def __init__(self, path: Path, choices: Iterable[str] = ()) -> None:
        """Read a record; columns are found by their mnemonics, or chosen (`drill_twin.scene.records.read_columns`).

        Raises:
            TableError: The record cannot be read, or has no time or no speed, or the weight of the block is no force.
        """
        self.path, self.damage = path, list[str]()
        columns = read_columns(path, choices)
        self.chosen = columns.given
        try:
            self.block = parse(" ".join(self.chosen[BLOCK]), FORCE) if BLOCK in self.chosen else math.nan
        except UnitError as error:
            raise TableError(f"{path}: {BLOCK}: {error}") from None
        for name in CHANNELS:
            if columns.named(name):
                with nullcontext() if columns.chosen(name)[0] else suppress(TableError):  # the account tells it
                    columns.channel(name)
        values = {name: one.values for name, one in columns.taken.items()}
        most = np.nanmax(values.get("hookload", math.inf), initial=0.0) or math.inf
        if self.block < 0.0 or self.block > most:
            raise TableError(f"{path}: {BLOCK}: expected 0 to {most:g} N (hookload), found {self.block:g} N")
        self.units = "field" if any(typed_in_pounds(one.unit.lower()) for one in columns.taken.values()) else "si"
        self.columns = list(columns.account())
        if "time" not in values or not any(name in values for name in _SPEEDS):
            known = "; ".join(f"{name}: {', '.join(CHANNELS[name].mnemonics)}" for name in ("time", *_SPEEDS))
            why = "; ".join(f"{one['column'][:60]}: {one['why']}" for one in self.columns[:20] if one["why"])
            raise TableError(
                f"{path}: expected columns of time and of the speed of top drive or bit with their units, found "
                f"{columns.listed} ({why}); name them with --channel, or in {path.name}.yaml; known names: {known}"
            )
        told = (f"{name} from {name_and_unit(one.column)[0]} [{one.unit}]" for name, one in columns.taken.items())
        self.read = f"{path.name}: {', '.join(told)}; converted to SI"
        self.notes = columns.told
        time = values["time"]
        if not np.nanmin(time, initial=0.0) >= 0.0:
            raise TableError(f"{path}: expected times from 0 s, found {np.nanmin(time):g} s; shift them")
        if not np.nanmax(time, initial=0.0) < _LATEST:
            raise TableError(f"{path}: expected times of at most {_LATEST:g} s, found {np.nanmax(time):g} s")
        dated = np.flatnonzero(np.isfinite(time))
        self._stamps = np.round(time[dated] * NANOSECONDS).astype(np.int64)
        self._values = {name: column[dated] for name, column in values.items() if name != "time"}
        self.topics = {RIG_STATE: contract_topic(RIG_STATE)} if dated.size else {}
        for topic in self.topics.values():
            topic.count = dated.size
        self.start, self.end = (int(self._stamps[0]), int(self._stamps.max())) if dated.size else (0, 0)

    def recorded_messages(self, topics: Collection[str] | None = None) -> Iterator[tuple[str, int, bytes]]:
        """As of `Bag`."""
        if topics is not None and RIG_STATE not in topics:
            return
        template = JointStateTemplate(RIG_JOINTS)
        for begin in range(0, self._stamps.size, _AT_ONCE):
            part = slice(begin, begin + _AT_ONCE)
            stamps = self._stamps[part].tolist()
            empty = np.full(len(stamps), math.nan)
            joints = (
                np.column_stack([self._values[name][part] if name in self._values else empty for name in names])
                for names in _JOINTS
            )
            for stamp, raw in zip(stamps, template.rows(stamps, *joints), strict=True):
                yield RIG_STATE, stamp, raw
