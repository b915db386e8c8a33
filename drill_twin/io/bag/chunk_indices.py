# SPDX-License-Identifier: Apache-2.0
"""Where the chunks of a file lie, kept small while it is written: ten chunks a second are 36 000 an hour.

As mcap's writer keeps them until the end of the file, a Python object each with a dictionary of its topics, the memory
of a recorder grows with the recording. Here they are kept as the bytes they will be in the file, compressed.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from io import BytesIO

from mcap.data_stream import ReadDataStream, RecordBuilder
from mcap.records import ChunkIndex
from mcap.writer import Writer

_TOGETHER = 256
_LIST = "_Writer__chunk_indices"


class PackedIndices:
    """Takes chunk indices and gives them back in order, which is all that the writer asks of its list."""

    def __init__(self) -> None:
        self._packed: list[bytes] = []
        self._open: list[ChunkIndex] = []

    def append(self, index: ChunkIndex) -> None:
        """Take one."""
        self._open.append(index)
        if len(self._open) == _TOGETHER:
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
        """Bytes of those that are packed."""
        return sum(map(len, self._packed))


def pack_indices(writer: Writer) -> None:
    """Have a new writer keep its chunk indices packed; one that keeps them elsewhere is left as it is."""
    if getattr(writer, _LIST, None) == []:
        setattr(writer, _LIST, PackedIndices())
