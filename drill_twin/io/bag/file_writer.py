# SPDX-License-Identifier: Apache-2.0
"""Writer of one MCAP file of a bag, at its end only; it notices what other programs do to the file meanwhile.

Parts of mcap's writer are replaced. mcap packs each field of a message and of an index by itself; here each record is
packed in one piece. mcap keeps a Python object for each chunk until the end of the file, and ten chunks a second are
36 000 an hour, so that a recorder's memory grows with the recording; here the indices are kept as compressed bytes.
"""

import os
import struct
import zlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from io import BufferedWriter, BytesIO, FileIO
from pathlib import Path
from typing import Any

from mcap.data_stream import ReadDataStream, RecordBuilder
from mcap.opcode import Opcode
from mcap.records import ChunkIndex
from mcap.writer import CompressionType, Writer

from drill_twin.core import __version__
from drill_twin.core.errors import BagError
from drill_twin.io.bag.metadata import RecordedTopic, to_yaml


class CheckedStream(BufferedWriter):
    """Binary stream to a new file, at its end only: a file that another program has cut gets no hole.

    Raises:
        OSError: The file exists, or cannot be created or written.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        super().__init__(FileIO(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_APPEND, 0o666), "ab"))
        self._size = 0

    def write(self, data: Any) -> int:
        """Append bytes."""
        self._size += len(data)
        return super().write(data)

    def tell(self) -> int:
        """Number of bytes written so far."""
        return self._size

    def close_at(self, size: int) -> None:
        """Close the file after an error of the disk, without what was begun after a size [bytes]."""
        with suppress(OSError), os.fdopen(os.dup(self.fileno()), "ab", buffering=0) as file:
            with suppress(OSError):  # fails for the same reason, or puts a part there
                self.close()
            if file.tell() > size:
                file.truncate(size)

    def change(self) -> str:
        """Another program's change of the flushed file, as `found it removed`; empty if there is none."""
        size = os.fstat(self.fileno()).st_size
        if size < self._size:
            return f"found it cut to {size} of {self._size} bytes"
        if size > self._size:
            return f"found {size - self._size} bytes of another program in it"
        try:
            there = self._path.stat()
        except OSError:
            return "found it removed"
        return "" if os.path.samestat(there, os.fstat(self.fileno())) else "found another file in its place"


_CHUNK_SIZE = 256 * 1024


class FileWriter:
    """Open MCAP file; an error of the disk closes it.

    Attributes:
        path: The file.
        start: Earliest time of recording [ns]; None before the first message.
        end: Latest time of recording [ns].
        count: Messages so far.
        lost: Messages not in the file after an error of the disk, or perhaps not after another program's change.

    Raises:
        OSError: Raised by the constructor if the file cannot be created.
        BagError: Raised by the methods if the file cannot be written.
    """

    def __init__(self, path: Path, topics: Iterable[RecordedTopic]) -> None:
        self.path = path
        self.start: int | None = None
        self.end = 0
        self.count = self.lost = 0
        self._kept = self._kept_size = 0  # messages and bytes that the operating system has
        self._stream = CheckedStream(path)
        self._writer = Writer(self._stream, chunk_size=_CHUNK_SIZE, compression=CompressionType.ZSTD)
        setattr(self._writer, _LIST, PackedIndices())
        self._append = message_appender(self._writer)
        self._writer.start(profile="ros2", library=f"drill_twin {__version__}")
        self._channels: dict[str, int] = {}
        self._schemas: dict[str, int] = {}
        for topic in topics:
            self.add_topic(topic)

    @property
    def size(self) -> int:
        """Size of the file [bytes], without the chunk that is still open."""
        return self._stream.tell()

    def add_topic(self, topic: RecordedTopic) -> None:
        """Register a topic before its first message."""
        if topic.type_name not in self._schemas:
            self._schemas[topic.type_name] = self._writer.register_schema(
                topic.type_name, "ros2msg", topic.definition.encode()
            )
        self._channels[topic.name] = self._writer.register_channel(
            topic.name,
            "cdr",
            self._schemas[topic.type_name],
            {"offered_qos_profiles": to_yaml(list(topic.qos)).strip(), "topic_type_hash": topic.type_hash},
        )

    def write(self, messages: Sequence[tuple[str, int, bytes, int]]) -> None:
        """Append messages: topic, time of recording [ns], bytes and number on the topic of each."""
        stamps = [stamp for _, stamp, _, _ in messages]
        self.start = min(stamps if self.start is None else (self.start, *stamps))
        self.end = max(self.end, *stamps)
        self.count += len(messages)
        channels = self._channels
        try:
            opened = self._append((channels[topic], stamp, raw, number) for topic, stamp, raw, number in messages)
            if self._stream.tell() > self._kept_size:  # a chunk was full
                self._stream.flush()
                self._kept, self._kept_size = self.count - opened, self._stream.tell()
        except OSError as error:
            raise self.broken(error) from error

    def flush(self) -> None:
        """Close the open chunk and pass it to the operating system."""
        try:
            self._writer.flush()  # type: ignore[no-untyped-call]
            self._stream.flush()
        except OSError as error:
            raise self.broken(error) from error
        self._kept, self._kept_size = self.count, self._stream.tell()

    def change(self) -> str:
        """Another program's change of the file since its last flush, in words; empty if there is none."""
        return self._stream.change()

    def abandon(self) -> None:
        """Close the file as another program has left it; it can be read as far as it goes."""
        self.lost = self.count
        with suppress(OSError):
            self._stream.close()

    def finish(self, information: Mapping[str, Any]) -> None:
        """Close the file; `information` is rosbag2's metadata of the bag."""
        self.flush()
        try:
            self._writer.add_metadata("rosbag2", {"serialized_metadata": to_yaml(information).strip()})
            self._writer.finish()  # type: ignore[no-untyped-call]
            self._stream.close()
        except OSError as error:
            raise self.broken(error) from error

    def broken(self, error: OSError) -> BagError:
        """Close the file after an error of the disk, behind its last whole chunk, and return the error to raise."""
        self._stream.close_at(self._kept_size)
        self.lost = self.count - self._kept
        return BagError(
            f"{self.path}: expected to go on writing the bag, found {error.strerror or error}; messages are lost, "
            f"{self.lost} so far; {self._kept} earlier messages can be read; make room, or choose another folder"
        )


# --- parts of mcap's writer ------------------------------------------------------------------------------------------

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
            if (index := indices.get(channel)) is None:
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
