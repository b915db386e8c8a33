# SPDX-License-Identifier: Apache-2.0
"""Reader of one MCAP file, complete or truncated: its topics and messages, in the order of the file.

A window of time is found by the index at the end of the file; a killed writer leaves none, and all is read.
"""

from __future__ import annotations

import struct
from collections.abc import Collection, Iterator
from io import BytesIO

from mcap.data_stream import ReadDataStream
from mcap.exceptions import EndOfFile
from mcap.opcode import Opcode
from mcap.records import Channel, Schema

from drill_twin.core.errors import BagError
from drill_twin.io.bag.metadata import RecordedTopic
from drill_twin.io.bag.reading.bag_file import WITH_HEADER, BagFile, qos_profiles
from drill_twin.io.bag.reading.mcap_records import (
    DAMAGED_RECORD,
    RECORD,
    RECORDS_IN_CHUNKS,
    Bounds,
    chunks_between,
    read_index,
    record_blocks,
)
from drill_twin.io.messages.stamps import raw_header_stamp

_MESSAGE = struct.Struct("<HIQQ")  # channel, sequence, log time, publish time
_MOST_NOTES = 10


class McapFile(BagFile):
    """Contents of one MCAP file, found in one pass."""

    def _open(self, window: tuple[float, float] | None) -> None:
        self._channels: dict[int, str | None] = {}
        self._schemas: dict[int, Schema] = {}
        self._notes = 0
        self._places: list[int] | None = None
        self._scanned = True  # damage that the search meets is noted when the messages are read
        if window is not None:
            self._places = self._places_of(*window)
        self._scanned = False
        for topic, stamp, _ in self.messages():
            if self._places is None:
                self.topics[topic].count += 1
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
        """As of `BagFile`, in the order of the file."""
        try:
            with self.path.open("rb") as stream:
                bounds = Bounds(self.path.stat().st_size)
                for data in record_blocks(stream, self.title, bounds, self._places, self._note):
                    yield from self._messages_in(data, topics, bounds)
                    if bounds.too_many():
                        self._note(f"expands to more than any recording of {bounds.file} bytes; the rest is left out")
                        return
        except OSError as error:
            raise BagError(f"{self.title}: expected a readable bag file, found {error.strerror or error}") from error

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
            self.damage.append(f"{self.title.name} {text}")
        elif self._notes == _MOST_NOTES + 1:
            self.damage.append(f"{self.title.name} has more such parts")
