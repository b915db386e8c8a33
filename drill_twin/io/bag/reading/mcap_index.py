# SPDX-License-Identifier: Apache-2.0
"""Index at the end of an MCAP file: its topics, their counts, and the places of the chunks."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from io import SEEK_END
from typing import BinaryIO

from mcap.opcode import Opcode
from mcap.writer import MCAP0_MAGIC

from drill_twin.io.bag.reading.decompression import LARGEST_CHUNK
from drill_twin.io.bag.reading.mcap_records import RECORD
from drill_twin.io.bag.reading.window import LATCHED, MOST_LATCHED, blocks_between
from drill_twin.io.messages.topics import DIAGNOSTICS, TWIN_SCENE

_FOOTER = struct.Struct("<BQQQI")  # opcode, length, start of the summary, of its offsets, checksum
_CHUNK = struct.Struct("<QQQQI")  # first and last time of recording, place, length, bytes of the map of channels
_STATISTICS = struct.Struct("<QHIIIIQQI")  # messages, schemas, channels, ..., chunks, first and last time, bytes of map
_COUNT = struct.Struct("<HQ")  # channel, number or place


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
    chunks: list[int]
    """Place of each chunk in the file [bytes], rising."""
    channels: list[bytes]
    """Channels of each chunk, packed."""

    def chunks_with(self, channel: int) -> list[int]:
        """Numbers of the chunks that have messages of a channel."""
        return [
            k
            for k, packed in enumerate(self.channels)
            if any(found == channel for found, _ in _COUNT.iter_unpack(packed))
        ]


def read_index(stream: BinaryIO) -> McapIndex | None:
    """Index of an open file; None if it has none or one that does not fit it, as after a kill."""
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
    chunks: list[tuple[int, bytes]] = []
    counts, times, place, number = dict[int, int](), (0, 0), 0, 0
    while place < len(summary):
        opcode, length = RECORD.unpack_from(summary, place)
        begin, place = place + RECORD.size, place + RECORD.size + length
        if opcode in {Opcode.SCHEMA, Opcode.CHANNEL}:
            definitions.append((Opcode(opcode), summary[begin:place]))
        elif opcode == Opcode.CHUNK_INDEX:
            _, _, at, extent, mapped = _CHUNK.unpack_from(summary, begin)
            if at + extent > size or extent < RECORD.size:
                return None
            chunks.append((at, summary[begin + _CHUNK.size : begin + _CHUNK.size + mapped]))
        elif opcode == Opcode.STATISTICS:
            *_, number, first, last, mapped = _STATISTICS.unpack_from(summary, begin)
            begin += _STATISTICS.size
            counts, times = dict(_COUNT.iter_unpack(summary[begin : begin + mapped])), (first, last)
    chunks.sort()
    if not chunks or number != len(chunks) or not all(packed for _, packed in chunks):
        return None
    return McapIndex(definitions, counts, *times, [at for at, _ in chunks], [packed for _, packed in chunks])


def chunks_between(
    index: McapIndex, names: Mapping[int, str], begin: float, end: float, stamps_at: Callable[[int], Sequence[int]]
) -> list[int] | None:
    """Places of the chunks with header stamps between two times, and of those with what is said once.

    Args:
        index: The index.
        names: Topic of each channel.
        begin: Earliest stamp [s].
        end: Latest stamp [s].
        stamps_at: Header stamps [ns] in the chunk at a place.

    Returns:
        The places; None where the file holds several runs, in which the stamps do not rise.
    """
    if any(count > 1 for channel, count in index.counts.items() if names[channel].endswith(TWIN_SCENE)):
        return None
    chosen = set(blocks_between(len(index.chunks), begin, end, lambda k: stamps_at(index.chunks[k])))
    for channel, name in names.items():
        if name.endswith(LATCHED):
            chosen.update(index.chunks_with(channel)[:MOST_LATCHED])
        elif name.endswith(DIAGNOSTICS):
            chosen.update(index.chunks_with(channel)[-1:])  # counts are those at the end of the run
    return [index.chunks[k] for k in sorted(chosen)]
