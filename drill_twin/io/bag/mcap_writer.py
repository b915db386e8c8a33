# SPDX-License-Identifier: Apache-2.0
"""Parts of mcap's writer that are replaced: messages and indices of a chunk, and the list of chunk indices.

mcap packs each field of a message and of an index by itself; here each record is packed in one piece. mcap keeps a
Python object for each chunk until the end of the file, and ten chunks a second are 36 000 an hour, so that a recorder's
memory grows with the recording; here the indices are kept as the compressed bytes of their records.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable, Iterable, Iterator
from io import BytesIO
from typing import Any

from mcap.data_stream import ReadDataStream, RecordBuilder
from mcap.opcode import Opcode
from mcap.records import ChunkIndex
from mcap.writer import Writer

_BLOCK = 256  # indices compressed together
_LIST = "_Writer__chunk_indices"


class PackedIndices:
    """Compressed list of chunk indices with the two methods that the writer needs: append and iterate."""

    def __init__(self) -> None:
        self._packed: list[bytes] = []
        self._open: list[ChunkIndex] = []

    def append(self, index: ChunkIndex) -> None:
        """Append an index."""
        self._open.append(index)
        if len(self._open) == _BLOCK:
            builder = RecordBuilder()
            for one in self._open:
                one.write(builder)
            self._packed.append(zlib.compress(builder.end()))  # type: ignore[no-untyped-call]
            self._open.clear()

    def __iter__(self) -> Iterator[ChunkIndex]:
        for packed in self._packed:
            content = zlib.decompress(packed)
            stream = ReadDataStream(BytesIO(content))
            while stream.count < len(content):
                stream.read1()  # opcode
                stream.read8()  # length
                yield ChunkIndex.read(stream)
        yield from self._open

    @property
    def size(self) -> int:
        """Size of the compressed indices [bytes]."""
        return sum(map(len, self._packed))


def pack_indices(writer: Writer) -> None:
    """Make a new writer keep its chunk indices compressed."""
    setattr(writer, _LIST, PackedIndices())


_HEAD = struct.Struct("<BQHIQQ")  # opcode, length of the rest, channel, sequence, time of recording and of publishing
_BEHIND_LENGTH = _HEAD.size - 9

Numbered = tuple[int, int, bytes, int]
"""Channel, time of recording [ns], bytes and number on the topic of a message."""
Append = Callable[[Iterable[Numbered]], int]
"""Appends messages; returns how many the open chunk holds."""


class _Index:
    """Index of the messages of a channel in a chunk, in place of mcap's `MessageIndex`."""

    def __init__(self, channel: int) -> None:
        self._channel = channel
        self.numbers: list[int] = []
        """Time of recording [ns] and place in the chunk, of each message in turn."""

    def write(self, stream: Any) -> None:
        """Write the record."""
        count = len(self.numbers)
        stream.write(
            struct.pack(f"<BQHI{count}Q", Opcode.MESSAGE_INDEX, 6 + 8 * count, self._channel, 8 * count, *self.numbers)
        )


def message_appender(writer: Writer) -> Append:
    """Append messages to a chunked writer as its `add_message`, to the same bytes; a session takes 7 % less time."""
    private: Any = writer
    chunk, statistics = private._Writer__chunk_builder, private._Writer__statistics  # noqa: SLF001
    finish_if_full, size = private._Writer__maybe_finalize_chunk, private._Writer__chunk_size  # noqa: SLF001
    counts, indices, pack, opcode = statistics.channel_message_counts, chunk.message_indices, _HEAD.pack, Opcode.MESSAGE

    def append(messages: Iterable[Numbered]) -> int:
        pieces: list[bytes] = []
        place = chunk.record_writer.count
        for channel, stamp, raw, number in messages:
            if chunk.num_messages == 0 or stamp < chunk.message_start_time:
                chunk.message_start_time = stamp
            chunk.message_end_time = max(chunk.message_end_time, stamp)
            if statistics.message_count == 0 or stamp < statistics.message_start_time:
                statistics.message_start_time = stamp
            statistics.message_end_time = max(statistics.message_end_time, stamp)
            counts[channel] += 1
            statistics.message_count += 1
            chunk.num_messages += 1
            index = indices.get(channel)
            if index is None:
                index = indices[channel] = _Index(channel)
            index.numbers += (stamp, place)
            pieces.append(pack(opcode, _BEHIND_LENGTH + len(raw), channel, number, stamp, stamp))
            pieces.append(raw)
            place += _HEAD.size + len(raw)
            if place > size:
                chunk.record_writer.write(b"".join(pieces))
                pieces.clear()
                finish_if_full()
                place = chunk.record_writer.count
        chunk.record_writer.write(b"".join(pieces))
        return int(chunk.num_messages)

    return append
