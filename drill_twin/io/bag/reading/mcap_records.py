# SPDX-License-Identifier: Apache-2.0
"""Records of an MCAP file, complete or truncated, the bounds on them, and the index at its end.

Every complete, undamaged chunk is read. The index has topics, their counts, and the places of the chunks.
"""

import struct
import zlib
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from io import SEEK_END, BytesIO
from pathlib import Path
from typing import BinaryIO

from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Chunk
from mcap.writer import MCAP0_MAGIC

from drill_twin.core.errors import BagError
from drill_twin.io.bag.reading.bag_file import LATCHED, MOST_LATCHED, blocks_between
from drill_twin.io.bag.reading.decompression import DAMAGED, LARGEST_CHUNK, decompressed
from drill_twin.io.messages.topics import DIAGNOSTICS, TWIN_SCENE

RECORD = struct.Struct("<BQ")
"""Opcode and length of a record."""
DAMAGED_RECORD = (McapError, struct.error, *DAMAGED)
"""Exceptions of the libraries on damaged bytes."""
RECORDS_IN_CHUNKS = frozenset({Opcode.SCHEMA, Opcode.CHANNEL, Opcode.MESSAGE})
"""Opcodes of the records that a chunk holds."""
Spans = Collection[tuple[int, int]] | None
_BLOCKS = {*RECORDS_IN_CHUNKS, Opcode.CHUNK}
_EXPANSION, _EXPANSION_OF_ANY = 200, 64_000_000  # bytes of content: per byte of the file, and beyond it
_RECORDS_OF_ANY = 100_000  # beyond one per byte of the file


@dataclass
class Bounds:
    """Bound on what a file of some size can have recorded; more is a bomb. Recorded motion compresses to a third."""

    file: int
    """Size of the file [bytes]."""
    size: int = 0
    """Bytes of content so far."""
    records: int = 0
    """Records so far."""

    def too_large(self, size: int) -> bool:
        """Return True where so many more bytes are too many; otherwise count them."""
        if self.size + size > _EXPANSION * self.file + _EXPANSION_OF_ANY or size > LARGEST_CHUNK:
            return True
        self.size += size
        return False

    def too_many(self) -> bool:
        """Return True where there are too many records so far."""
        return self.records > self.file + _RECORDS_OF_ANY


def record_blocks(
    stream: BinaryIO, title: Path, bounds: Bounds, spans: Spans, note: Callable[[str], None]
) -> Iterator[tuple[int, int, bytes]]:
    """Blocks of records of an MCAP file: the content of each chunk, and each record outside of chunks.

    Each block comes after the bytes of the file at which it begins and ends.

    Args:
        stream: The file from its beginning.
        title: Its name in messages.
        bounds: Bounds on its content.
        spans: Bytes of the file at which records that are wanted begin, the second excluded; None: all.
        note: Called with a sentence on each part that is missing, damaged or left out.

    Raises:
        BagError: The stream is not an MCAP file.
    """
    if stream.read(len(MCAP0_MAGIC)) != MCAP0_MAGIC:
        found = f"{bounds.file} bytes that do not start as one" if bounds.file else "an empty file"
        raise BagError(f"{title}: expected an MCAP file, found {found}; record the run again")
    for begin, end in [(len(MCAP0_MAGIC), bounds.file + 1)] if spans is None else spans:
        opcode, place = 0, stream.seek(begin)
        while place < end and opcode != Opcode.FOOTER:
            head = stream.read(RECORD.size)
            opcode, length = RECORD.unpack(head) if len(head) == RECORD.size else (0, 0)
            after = place + RECORD.size + length
            if opcode == 0 or after > bounds.file:
                note(f"ends in the middle of a record, at byte {place} of {bounds.file}")
                break
            if opcode in _BLOCKS and length > LARGEST_CHUNK:
                note(f"has a record of more than {LARGEST_CHUNK} bytes at byte {place}, which is left out")
            elif opcode == Opcode.CHUNK:
                yield place, after, _chunk(stream.read(length), place, bounds, note)
            elif opcode in RECORDS_IN_CHUNKS:
                yield place, after, head + stream.read(length)
            elif spans:
                note(f"has no chunk at byte {place}, where its index has one")
            place = stream.seek(after)


def _chunk(record: bytes, place: int, bounds: Bounds, note: Callable[[str], None]) -> bytes:
    """Content of a chunk; empty where it is damaged, not as large as it says, or larger than the bounds."""
    with suppress(*DAMAGED_RECORD):
        chunk = Chunk.read(ReadDataStream(BytesIO(record)))
        if bounds.too_large(chunk.uncompressed_size):
            note(f"has a chunk at byte {place} larger than any in {bounds.file} bytes, which is left out")
            return b""
        data = decompressed(chunk.compression, chunk.data, chunk.uncompressed_size)
        if chunk.uncompressed_crc in {0, zlib.crc32(data)}:
            return data
    note(f"has a damaged chunk at byte {place}, which is left out")
    return b""


_FOOTER = struct.Struct("<BQQQI")  # opcode, length, start of the summary, of its offsets, checksum
_CHUNK = struct.Struct("<QQQQI")  # first and last time of recording, place, length, bytes of the map of channels
_STATISTICS = struct.Struct("<QHIIIIQQI")  # messages, schemas, channels, ..., chunks, first and last time, bytes of map
_COUNT = struct.Struct("<HQ")  # channel, number or place


_IndexedChunk = tuple[int, int, tuple[int, int], bytes]
"""Earliest and latest time of recording [ns], begin and end in the file [bytes], channels with messages, packed."""


@dataclass(frozen=True)
class McapIndex:
    """Index of a complete file."""

    definitions: list[tuple[Opcode, bytes]]
    """Opcode and content of the record of each schema and channel."""
    counts: dict[int, int]
    """Messages by channel."""
    start: int
    """Earliest time of recording [ns]."""
    end: int
    """Latest time of recording [ns]."""
    chunks: list[_IndexedChunk]
    """Chunks in order of time."""

    def chunks_with(self, channel: int) -> list[int]:
        """Numbers of the chunks that have messages of a channel."""
        chunks = enumerate(self.chunks)
        return [k for k, (*_, packed) in chunks if any(found == channel for found, _ in _COUNT.iter_unpack(packed))]


def read_index(stream: BinaryIO) -> McapIndex | None:
    """Index of an open file; None if the file has no index, or an index that does not fit, as after a kill."""
    size = stream.seek(0, SEEK_END)
    place = size - len(MCAP0_MAGIC) - _FOOTER.size
    if place < 0:
        return None
    stream.seek(place)
    footer = stream.read(_FOOTER.size)
    opcode, length, begin, _, checksum = _FOOTER.unpack(footer)
    if opcode != Opcode.FOOTER or length != _FOOTER.size - RECORD.size or not 0 < begin < place:
        return None
    if place - begin > LARGEST_CHUNK or stream.read() != MCAP0_MAGIC:
        return None
    stream.seek(begin)
    summary = stream.read(place - begin)
    if checksum != zlib.crc32(footer[:-4], zlib.crc32(summary)):
        return None
    try:
        return _parse(summary, begin)
    except (struct.error, ValueError):
        return None


def _parse(summary: bytes, size: int) -> McapIndex | None:
    definitions: list[tuple[Opcode, bytes]] = []
    chunks: list[_IndexedChunk] = []
    counts, times, place, number = dict[int, int](), (0, 0), 0, 0
    while place < len(summary):
        opcode, length = RECORD.unpack_from(summary, place)
        begin, place = place + RECORD.size, place + RECORD.size + length
        if opcode in {Opcode.SCHEMA, Opcode.CHANNEL}:
            definitions.append((Opcode(opcode), summary[begin:place]))
        elif opcode == Opcode.CHUNK_INDEX:
            first, last, at, extent, mapped = _CHUNK.unpack_from(summary, begin)
            if at + extent > size or extent < RECORD.size:
                return None
            chunks.append((first, last, (at, at + extent), summary[begin + _CHUNK.size : begin + _CHUNK.size + mapped]))
        elif opcode == Opcode.STATISTICS:
            *_, number, first, last, mapped = _STATISTICS.unpack_from(summary, begin)
            begin += _STATISTICS.size
            counts, times = dict(_COUNT.iter_unpack(summary[begin : begin + mapped])), (first, last)
    chunks.sort()
    if not chunks or number != len(chunks) or not all(packed for *_, packed in chunks):
        return None
    return McapIndex(definitions, counts, *times, chunks)


def chunks_between(
    index: McapIndex,
    names: Mapping[int, str],
    begin: float,
    end: float,
    stamps_at: Callable[[tuple[int, int]], Sequence[int]],
) -> Spans:
    """Spans of the chunks with header stamps between two times, of chunks that overlap them in time of recording,
    and of chunks with what is said once.

    Args:
        index: The index.
        names: Topic of each channel.
        begin: Earliest stamp [s].
        end: Latest stamp [s].
        stamps_at: Header stamps [ns] in the chunk between two bytes of the file.

    Returns:
        The spans, for `record_blocks`; None where the file holds several runs, in which the stamps do not rise.
    """
    if any(count > 1 for channel, count in index.counts.items() if names[channel].endswith(TWIN_SCENE)):
        return None
    chunks = index.chunks
    found = blocks_between(len(chunks), begin, end, lambda k: stamps_at(chunks[k][2]))
    earliest, latest = chunks[found[0]][0], max(chunks[k][1] for k in found)
    chosen = {*found, *(k for k, (first, last, *_) in enumerate(chunks) if first < latest and last > earliest)}
    for channel, name in names.items():
        if name.endswith(LATCHED):
            chosen.update(index.chunks_with(channel)[:MOST_LATCHED])
        elif name.endswith(DIAGNOSTICS):
            chosen.update(index.chunks_with(channel)[-1:])  # with the counts at the end of the run
    return [chunks[k][2] for k in sorted(chosen)]
