# SPDX-License-Identifier: Apache-2.0
"""Records of an MCAP file, complete or truncated, and the bounds on them: every complete, undamaged chunk is read."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass
from io import SEEK_CUR, BytesIO
from pathlib import Path
from typing import BinaryIO

from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Chunk
from mcap.writer import MCAP0_MAGIC

from drill_twin.core.errors import BagError
from drill_twin.io.bag.reading.decompression import DAMAGED, LARGEST_CHUNK, decompressed

RECORD = struct.Struct("<BQ")
"""Opcode and length of a record."""
DAMAGED_RECORD = (McapError, struct.error, *DAMAGED)
"""Exceptions of the libraries on damaged bytes."""
RECORDS_IN_CHUNKS = frozenset({Opcode.SCHEMA, Opcode.CHANNEL, Opcode.MESSAGE})
"""Opcodes of the records that a chunk holds."""
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
        """Check that so many bytes more are too many; they are counted otherwise."""
        if self.size + size > _EXPANSION * self.file + _EXPANSION_OF_ANY or size > LARGEST_CHUNK:
            return True
        self.size += size
        return False

    def too_many(self) -> bool:
        """Check the number of records so far."""
        return self.records > self.file + _RECORDS_OF_ANY


class _TooLargeError(Exception):
    """A chunk that says that it is larger than the bounds."""


def record_blocks(
    stream: BinaryIO, title: Path, bounds: Bounds, places: Collection[int] | None, note: Callable[[str], None]
) -> Iterator[bytes]:
    """Blocks of records of an MCAP file: the content of each chunk, and each record outside of chunks.

    Args:
        stream: The file from its beginning.
        title: Its name in messages.
        bounds: Bounds on its content.
        places: Places of the chunks that are wanted; None: all, and what is outside of chunks.
        note: Called with a sentence on each part that is missing, damaged or left out.

    Raises:
        BagError: It is not an MCAP file.
    """
    size = bounds.file
    if stream.read(len(MCAP0_MAGIC)) != MCAP0_MAGIC:
        found = f"{size} bytes that do not start as one" if size else "an empty file"
        raise BagError(f"{title}: expected an MCAP file, found {found}; record the run again")
    for place in places or ():
        stream.seek(place)
        opcode, length = _head(stream.read(RECORD.size))
        if opcode != Opcode.CHUNK or length > LARGEST_CHUNK:
            note(f"has no chunk at byte {place}, where its index has one")
        else:
            yield from _chunk(stream.read(length), place, bounds, note)
    if places is not None:
        return
    opcode, place = 0, stream.tell()
    while opcode != Opcode.FOOTER:
        head = stream.read(RECORD.size)
        opcode, length = _head(head)
        if opcode == 0 or stream.tell() + length > size:
            note(f"ends in the middle of a record, at byte {place} of {size}")
            return
        if opcode in _BLOCKS and length > LARGEST_CHUNK:
            note(f"has a record of more than {LARGEST_CHUNK} bytes at byte {place}, which is left out")
            stream.seek(length, SEEK_CUR)
        elif opcode == Opcode.CHUNK:
            yield from _chunk(stream.read(length), place, bounds, note)
        elif opcode in RECORDS_IN_CHUNKS:
            yield head + stream.read(length)
        else:
            stream.seek(length, SEEK_CUR)
        place = stream.tell()


def _head(head: bytes) -> tuple[int, int]:
    """Opcode and length of a record; zeros where the file ends."""
    return RECORD.unpack(head) if len(head) == RECORD.size else (0, 0)


def _chunk(record: bytes, place: int, bounds: Bounds, note: Callable[[str], None]) -> Iterator[bytes]:
    """Content of a chunk; nothing where it is damaged."""
    try:
        yield _content(record, bounds)
    except _TooLargeError:
        note(f"has a chunk at byte {place} larger than any in {bounds.file} bytes, which is left out")
    except DAMAGED_RECORD:
        note(f"has a damaged chunk at byte {place}, which is left out")


def _content(record: bytes, bounds: Bounds) -> bytes:
    """Records in a chunk.

    Raises:
        _TooLargeError: It would be larger than the bounds.
        Exceptions of `DAMAGED_RECORD`: It is damaged, or not as large as it says.
    """
    chunk = Chunk.read(ReadDataStream(BytesIO(record)))
    if bounds.too_large(chunk.uncompressed_size):
        raise _TooLargeError
    data = decompressed(chunk.compression, chunk.data, chunk.uncompressed_size)
    if chunk.uncompressed_crc not in {0, zlib.crc32(data)}:
        raise ValueError("another checksum")
    return data
