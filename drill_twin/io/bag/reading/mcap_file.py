# SPDX-License-Identifier: Apache-2.0
"""Reader of one MCAP file, complete or truncated: its topics and messages, in the order of the file.

A window of time is found by the index at the end of the file; a killed writer leaves none, and all is read.
"""

from __future__ import annotations

import struct
from collections.abc import Collection, Iterator
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path

from mcap.data_stream import ReadDataStream
from mcap.exceptions import EndOfFile
from mcap.opcode import Opcode
from mcap.records import Channel, Schema

from drill_twin.core.errors import BagError
from drill_twin.io.bag.metadata import RecordedTopic
from drill_twin.io.bag.reading.decompression import decompressed_message
from drill_twin.io.bag.reading.mcap_index import chunks_between, read_index
from drill_twin.io.bag.reading.mcap_records import DAMAGED_RECORD, RECORD, RECORDS_IN_CHUNKS, Bounds, record_blocks
from drill_twin.io.bag.reading.qos import qos_profiles
from drill_twin.io.bag.reading.window import WITH_HEADER
from drill_twin.io.messages.stamps import raw_header_stamp

_MESSAGE = struct.Struct("<HIQQ")  # channel, sequence, log time, publish time
_MOST_NOTES = 10


@dataclass
class McapFile:
    """Contents of one MCAP file, found in one pass."""

    path: Path
    topics: dict[str, RecordedTopic] = field(default_factory=dict)
    """Topics by name, including those without messages."""
    start: int | None = None
    """Earliest time of recording [ns]; None without messages."""
    end: int | None = None
    """Latest time of recording [ns]."""
    damage: list[str] = field(default_factory=list)
    """Sentences on missing or damaged parts; empty for a complete file."""
    name: Path | None = None
    """Name in messages, if the file was decompressed from another."""
    compressed_messages: bool = False
    """True if rosbag2 compressed each message."""
    temporary: object = None
    """Temporary file that `path` names, removed with this reader."""
    window: tuple[float, float] | None = None
    """Header stamps [s] between which messages are wanted; others may come with them. None: all."""

    def __post_init__(self) -> None:
        self._channels: dict[int, str | None] = {}
        self._schemas: dict[int, Schema] = {}
        self._notes = 0
        self._places: list[int] | None = None
        self._scanned = True  # what the search finds damaged is told where it is read
        if self.window is not None:
            self._places = self._places_of(*self.window)
        self._scanned = False
        for name, stamp, _ in self.messages():
            if self._places is None:
                self.topics[name].count += 1
                self.start = stamp if self.start is None else min(self.start, stamp)
                self.end = stamp if self.end is None else max(self.end, stamp)
        self._scanned = True

    def _places_of(self, begin: float, end: float) -> list[int] | None:
        """Places of the chunks with header stamps between two times [s], by the index; None to read all."""
        try:
            with self.path.open("rb") as stream:
                index = read_index(stream)
        except OSError:
            return None
        if index is None:
            return None
        try:
            for opcode, content in index.definitions:
                self._register(opcode, ReadDataStream(BytesIO(content)))
        except DAMAGED_RECORD:
            return None
        names = {channel: self._channels.get(channel) or "" for channel in index.counts}
        chosen = chunks_between(index, names, begin, end, self._stamps_at)
        self._places = None
        if chosen is not None:
            self.start, self.end = index.start, index.end
            for channel, count in index.counts.items():
                if name := names[channel]:
                    self.topics[name].count += count
        return chosen

    def _stamps_at(self, place: int) -> list[int]:
        """Header stamps [ns] in the chunk at a place."""
        self._places = [place]
        headed = {name for name, topic in self.topics.items() if topic.type_name in WITH_HEADER}
        return [raw_header_stamp(raw) for _, _, raw in self.messages(headed)]

    def messages(self, topics: Collection[str] | None = None) -> Iterator[tuple[str, int, bytes]]:
        """Topic, time of recording [ns] and CDR of each message, in the order of the file.

        Raises:
            BagError: The file cannot be read, or is not an MCAP file.
        """
        try:
            with self.path.open("rb") as stream:
                bounds = Bounds(self.path.stat().st_size)
                for data in record_blocks(stream, self._title, bounds, self._places, self._note):
                    yield from self._messages_in(data, topics, bounds)
                    if bounds.too_many():
                        self._note(f"expands to more than any recording of {bounds.file} bytes; the rest is left out")
                        return
        except OSError as error:
            raise BagError(f"{self._title}: expected a readable bag file, found {error.strerror or error}") from error

    @property
    def _title(self) -> Path:
        return self.name or self.path

    def _messages_in(
        self, data: bytes, topics: Collection[str] | None, bounds: Bounds
    ) -> Iterator[tuple[str, int, bytes]]:
        place, size, unregistered = 0, len(data), 0
        try:
            while place < size:
                opcode, length = RECORD.unpack_from(data, place)
                start, place = place + RECORD.size, place + RECORD.size + length
                if place > size or not opcode:
                    raise EndOfFile
                bounds.records += 1
                if bounds.too_many():
                    return
                if opcode == Opcode.MESSAGE:
                    channel, _, stamp, _ = _MESSAGE.unpack_from(data, start)
                    name = self._channels.get(channel)
                    if name is None:
                        unregistered += channel not in self._channels
                    elif topics is None or name in topics:
                        yield name, stamp, self._message(data[start + _MESSAGE.size : place])
                elif opcode in RECORDS_IN_CHUNKS:
                    self._register(opcode, ReadDataStream(BytesIO(data[start:place])))
        except DAMAGED_RECORD:
            self._note("has damaged records inside a chunk, which are left out")
        if unregistered:
            self._note(f"has {unregistered} messages on topics whose names were lost with a damaged chunk")

    def _message(self, raw: bytes) -> bytes:
        return decompressed_message(raw) if self.compressed_messages else raw

    def _register(self, opcode: int, stream: ReadDataStream) -> None:
        """Register a message definition or a channel; a channel that is not of ROS 2 gets no topic name."""
        if opcode == Opcode.SCHEMA:
            schema = Schema.read(stream)
            self._schemas[schema.id] = schema
            return
        channel = Channel.read(stream)
        definition = self._schemas.get(channel.schema_id)
        if channel.id in self._channels:
            return
        if channel.message_encoding != "cdr" or definition is None:
            self._channels[channel.id] = None
            return
        self._channels[channel.id] = channel.topic
        self.topics.setdefault(
            channel.topic,
            RecordedTopic(
                channel.topic,
                definition.name,
                definition.data.decode("utf-8", "replace"),
                channel.metadata.get("topic_type_hash", ""),
                qos_profiles(channel.metadata.get("offered_qos_profiles", "")),
            ),
        )

    def _note(self, text: str) -> None:
        if self._scanned:
            return
        self._notes += 1
        if self._notes <= _MOST_NOTES:
            self.damage.append(f"{self._title.name} {text}")
        elif self._notes == _MOST_NOTES + 1:
            self.damage.append(f"{self._title.name} has more such parts")
