# SPDX-License-Identifier: Apache-2.0
"""Reader of one MCAP file, complete or truncated: its topics and messages, in order of the time of recording.

A window of time is found by the index at the end of the file; a killed writer leaves none, and all is read. A file in
order is read from its beginning to its end. Of another file, each group of messages is read when its first is due, and
the groups that overlap in time are merged.
"""

import struct
from collections.abc import Collection, Iterator
from heapq import merge
from io import BytesIO
from itertools import accumulate
from operator import itemgetter

from mcap.data_stream import ReadDataStream
from mcap.exceptions import EndOfFile
from mcap.opcode import Opcode
from mcap.records import Channel, Schema

from drill_twin.core.errors import BagError
from drill_twin.io.bag.metadata import RecordedTopic
from drill_twin.io.bag.reading.bag_file import BagFile, qos_profiles
from drill_twin.io.bag.reading.decompression import LARGEST_CHUNK
from drill_twin.io.bag.reading.mcap_records import (
    DAMAGED_RECORD,
    RECORD,
    RECORDS_IN_CHUNKS,
    Bounds,
    Spans,
    chunks_between,
    read_index,
    record_blocks,
)
from drill_twin.io.messages.stamps import NANOSECONDS, raw_header_stamp
from drill_twin.io.messages.topic_row import WITH_HEADER

_MESSAGE = struct.Struct("<HIQQ")  # channel, sequence, log time, publish time
_MOST_NOTES = 10
_GROUP = 1 << 18  # bytes from which a group of messages is full
_ROW = 150  # bytes that a message takes beside its content

Row = tuple[str, int, bytes]


class McapFile(BagFile):
    """Contents of one MCAP file, found in one pass."""

    def _open(self, window: tuple[float, float] | None) -> None:
        self._channels: dict[int, str | None] = {}
        self._schemas: dict[int, Schema] = {}
        self._spans: Spans = None
        # Of messages that lie side by side: earliest and latest time [ns], memory that they take [bytes], begin and end
        # in the file [bytes]. Empty where messages are read in the order of the file.
        self._groups: list[tuple[int, ...]] = []
        self._scanned = True  # damage that the search meets is noted when the messages are read
        if window is not None:
            self._spans = self._spans_of(*window)
        self._scanned = False
        self._scan()
        self._scanned = True

    def _scan(self) -> None:
        """Read all messages for their number and times, and group them where they are to be sorted."""
        groups: list[tuple[int, ...]] = []
        latest, late, whole, is_read = 0, 0, self._spans is None, False
        for begin, end, rows in self._blocks(self._spans):
            more = whole and is_read and groups and groups[-1][2] < _GROUP
            first, last, size, start, before = groups.pop() if more else (1 << 64, -1, 0, begin, end)
            known = size
            for topic, stamp, raw in rows:
                if whole:
                    self.topics[topic].count += 1
                if size and stamp >= latest:
                    last = latest = stamp
                else:
                    first, last = min(first, stamp), max(last, stamp)
                    late, latest = max(late, latest - stamp), max(latest, stamp)
                size += _ROW + len(raw)
            is_read = size > known  # what was left out is in no group, so it is not read again
            if size:
                groups.append((first, last, size, start, end if is_read else before))
        if whole and groups:
            self.start, self.end = min(groups)[0], max(last for _, last, *_ in groups)
        if late:
            changes = sorted(x for first, last, size, *_ in groups for x in ((first, 0, size), (last, 1, -size)))
            held = max(accumulate(size for *_, size in changes)) + 1000 * len(groups)  # bytes, with what waits
            self._groups = groups if (fits := held <= LARGEST_CHUNK and not self._has_several_runs()) else []
            done = "sorted" if fits else "read as they lie: there are several runs, or too many overlap in time"
            if late > NANOSECONDS:  # less between topics is usual
                self.notes.append(
                    f"{self.title.name} is not in order of the time of recording: its messages are {done}"
                )

    def _spans_of(self, begin: float, end: float) -> Spans:
        """Spans of the chunks with header stamps between two times [s], by the index; None to read all."""
        try:
            with self.path.open("rb") as stream:
                if (index := read_index(stream)) is None:
                    return None
            for opcode, content in index.definitions:
                self._register(opcode, ReadDataStream(BytesIO(content)))
        except (OSError, *DAMAGED_RECORD):
            return None
        names = {channel: self._channels.get(channel) or "" for channel in index.counts}
        chosen = chunks_between(index, names, begin, end, self._stamps_at)
        self._spans = None
        if chosen is not None:
            self.start, self.end = index.start, index.end
            for channel, count in index.counts.items():
                if name := names[channel]:
                    self.topics[name].count += count
        return chosen

    def _stamps_at(self, span: tuple[int, int]) -> list[int]:
        """Header stamps [ns] in the chunk between two bytes of the file."""
        self._spans = [span]
        headed = {name for name, topic in self.topics.items() if topic.type_name in WITH_HEADER}
        return [raw_header_stamp(raw) for _, _, raw in self.messages(headed)]

    def messages(self, topics: Collection[str] | None = None) -> Iterator[Row]:
        """As of `BagFile`, in order of time; messages of one time in the order of the file."""
        if self._groups:
            groups = (self._sorted(first, (begin, end), topics) for first, *_, begin, end in self._groups)
            yield from (row for row in merge(*groups, key=itemgetter(1)) if row[0])
            return
        for *_, rows in self._blocks(self._spans, topics):
            yield from rows

    def _sorted(self, first: int, span: tuple[int, int], topics: Collection[str] | None) -> Iterator[Row]:
        """Messages of a group in order of time, read when the first is due: an empty one of its time comes before."""
        yield "", first, b""
        yield from sorted((row for *_, rows in self._blocks([span], topics) for row in rows), key=itemgetter(1))

    def _blocks(self, spans: Spans, topics: Collection[str] | None = None) -> Iterator[tuple[int, int, Iterator[Row]]]:
        """Blocks of the file: the bytes at which each begins and ends, and its messages."""
        try:
            with self.path.open("rb") as stream:
                bounds = Bounds(self.path.stat().st_size)
                for begin, end, data in record_blocks(stream, self.title, bounds, spans, self._note):
                    yield begin, end, self._messages_in(data, topics, bounds)
                    if bounds.too_many():
                        self._note(f"expands to more than any recording of {bounds.file} bytes; the rest is left out")
                        return
        except OSError as error:
            raise BagError(f"{self.title}: expected a readable bag, found {error.strerror or error}") from error

    def _messages_in(self, data: bytes, topics: Collection[str] | None, bounds: Bounds) -> Iterator[Row]:
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
        if not self._scanned and len(self.damage) <= _MOST_NOTES:
            self.damage.append(f"{self.title.name} {text if len(self.damage) < _MOST_NOTES else 'has more such parts'}")
