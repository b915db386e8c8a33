# SPDX-License-Identifier: Apache-2.0
"""Sequential reader of one MCAP file, complete or truncated: every complete, undamaged chunk is read.

The index at the end is not used, because a killed writer leaves none.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Collection, Iterator
from dataclasses import dataclass, field
from functools import lru_cache
from io import SEEK_CUR, BytesIO
from pathlib import Path
from typing import BinaryIO

import lz4.frame  # type: ignore[import-untyped]
import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import EndOfFile, McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Schema
from mcap.writer import MCAP0_MAGIC
from rosbags.rosbag2.errors import ReaderError
from rosbags.rosbag2.metadata import dump_qos_v9, parse_qos

from drill_twin.errors import BagError
from drill_twin.io.bag.metadata import Qos, RecordedTopic

_RECORD = struct.Struct("<BQ")  # opcode, length
_MESSAGE = struct.Struct("<HIQQ")  # channel, sequence, log time, publish time
_DAMAGED = (McapError, struct.error, ValueError, zstandard.ZstdError, RuntimeError, OverflowError, MemoryError)
"""Exceptions of the libraries on damaged bytes."""


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

    def __post_init__(self) -> None:
        self._channels: dict[int, str | None] = {}
        self._schemas: dict[int, Schema] = {}
        self._scanned = False
        for name, stamp, _ in self.messages():
            self.topics[name].count += 1
            self.start = stamp if self.start is None else min(self.start, stamp)
            self.end = stamp if self.end is None else max(self.end, stamp)
        self._scanned = True

    def messages(self, topics: Collection[str] | None = None) -> Iterator[tuple[str, int, bytes]]:
        """Topic, time of recording [ns] and CDR of each message, in the order of the file.

        Raises:
            BagError: The file cannot be read, or is not an MCAP file.
        """
        try:
            with self.path.open("rb") as stream:
                for data in self._record_blocks(stream):
                    yield from self._messages_in(data, topics)
        except OSError as error:
            raise BagError(f"{self.path}: expected a readable bag file, found {error.strerror or error}") from error

    def _record_blocks(self, stream: BinaryIO) -> Iterator[bytes]:
        """Blocks of records: the content of each chunk, and each record outside of chunks."""
        size = self.path.stat().st_size
        if stream.read(len(MCAP0_MAGIC)) != MCAP0_MAGIC:
            found = f"{size} bytes that do not start as one" if size else "an empty file"
            raise BagError(f"{self.path}: expected an MCAP file, found {found}; record the run again")
        opcode, place = 0, stream.tell()
        while opcode != Opcode.FOOTER:
            head = stream.read(_RECORD.size)
            opcode, length = _RECORD.unpack(head) if len(head) == _RECORD.size else (0, 0)
            if opcode == 0 or stream.tell() + length > size:
                self._note(f"ends in the middle of a record, at byte {place} of {size}")
                return
            if opcode == Opcode.CHUNK:
                content = _decompressed(stream.read(length))
                if content is None:
                    self._note(f"has a damaged chunk at byte {place}, which is left out")
                else:
                    yield content
            elif opcode in {Opcode.SCHEMA, Opcode.CHANNEL, Opcode.MESSAGE}:
                yield head + stream.read(length)
            else:
                stream.seek(length, SEEK_CUR)
            place = stream.tell()

    def _messages_in(self, data: bytes, topics: Collection[str] | None) -> Iterator[tuple[str, int, bytes]]:
        place, size, unregistered = 0, len(data), 0
        try:
            while place < size:
                opcode, length = _RECORD.unpack_from(data, place)
                start, place = place + _RECORD.size, place + _RECORD.size + length
                if place > size:
                    raise EndOfFile
                if opcode == Opcode.MESSAGE:
                    channel, _, stamp, _ = _MESSAGE.unpack_from(data, start)
                    name = self._channels.get(channel)
                    if name is None:
                        unregistered += channel not in self._channels
                    elif topics is None or name in topics:
                        yield name, stamp, data[start + _MESSAGE.size : place]
                elif opcode in {Opcode.SCHEMA, Opcode.CHANNEL}:
                    self._register(opcode, ReadDataStream(BytesIO(data[start:place])))
        except _DAMAGED:
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
                _qos(channel.metadata.get("offered_qos_profiles", "")),
            ),
        )

    def _note(self, text: str) -> None:
        if not self._scanned:
            self.damage.append(f"{self.path.name} {text}")


def _decompressed(record: bytes) -> bytes | None:
    """Records in a chunk; None if it is damaged."""
    try:
        chunk = Chunk.read(ReadDataStream(BytesIO(record)))
        if chunk.compression == "zstd":
            data = zstandard.ZstdDecompressor().decompress(chunk.data, chunk.uncompressed_size)
        elif chunk.compression == "lz4":
            data = bytes(lz4.frame.decompress(chunk.data))
        elif chunk.compression:
            return None
        else:
            data = chunk.data
    except _DAMAGED:
        return None
    intact = len(data) == chunk.uncompressed_size and chunk.uncompressed_crc in {0, zlib.crc32(data)}
    return data if intact else None


@lru_cache(maxsize=64)
def _qos(text: str) -> tuple[Qos, ...]:
    """QoS profiles in the format of version 9; empty where another tool wrote another format."""
    try:
        return tuple(dict(profile) for profile in dump_qos_v9(parse_qos(text)))
    except (ReaderError, KeyError, TypeError, AttributeError):
        return ()
