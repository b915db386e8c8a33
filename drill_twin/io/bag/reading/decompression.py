# SPDX-License-Identifier: Apache-2.0
"""Decompression of data of unknown origin: no more is written than was announced, and no more than the largest chunk.

The size in the header of an lz4 frame is checked before, since its library reserves that much; the output is bounded
too, since a frame may have no size in its header. The content of zstd frames comes in blocks.
"""

from collections.abc import Callable
from io import BytesIO
from typing import IO

import lz4.frame  # type: ignore[import-untyped]
import zstandard

LARGEST_CHUNK = 128_000_000
"""Most bytes of a chunk, a message or a record; rosbag2 writes chunks of 0.8 MB, this package of 0.3 MB."""
_BLOCK = 1 << 20
_LARGEST_WINDOW = 1 << 27  # bytes; the window of `zstd --ultra -22`

DAMAGED = (zstandard.ZstdError, RuntimeError, ValueError, OverflowError, MemoryError, EOFError)
"""Exceptions on damaged or oversized frames."""


def decompressed(kind: str, data: bytes, size: int) -> bytes:
    """Content of a frame.

    Args:
        kind: `zstd`, `lz4`, or empty for data that is not compressed.
        data: The frame.
        size: Size of the content [bytes] as announced elsewhere.

    Raises:
        ValueError: Another kind, or another size; other exceptions of `DAMAGED` for damage.
    """
    if not 0 <= size <= LARGEST_CHUNK:
        raise ValueError(f"{size} bytes where at most {LARGEST_CHUNK} can be meant")
    if kind not in _CONTENT:
        raise ValueError(f"compression {kind[:20]!r}")
    content = _CONTENT[kind](data, size)
    if len(content) != size:
        raise ValueError(f"{len(content)} bytes instead of {size}")
    return content


def of_zstd(data: bytes, largest: int) -> bytes:
    """Content of zstd frames, of at most `largest` bytes.

    Raises:
        Exceptions of `DAMAGED`.
    """
    target = BytesIO()
    decompress_stream(BytesIO(data), target, largest)
    return target.getvalue()


def decompress_stream(source: IO[bytes], target: IO[bytes], largest: int) -> None:
    """Decompress zstd frames from one open file to another.

    Raises:
        ValueError: The content is larger than `largest` bytes; other exceptions of `DAMAGED` for damage.
    """
    written = 0
    with zstandard.ZstdDecompressor(max_window_size=_LARGEST_WINDOW).stream_reader(
        source, read_across_frames=True, closefd=False
    ) as reader:
        while block := reader.read(_BLOCK):
            written += len(block)
            if written > largest:
                raise ValueError(f"more than {largest} bytes")
            target.write(block)


def _lz4(data: bytes, size: int) -> bytes:
    announced = lz4.frame.get_frame_info(data)["content_size"]
    if announced not in {0, size}:
        raise ValueError(f"a frame of {announced} bytes instead of {size}")
    decompressor = lz4.frame.LZ4FrameDecompressor()
    content: bytes = decompressor.decompress(data, max_length=size + 1)
    if not decompressor.eof:
        raise EOFError
    return content


_CONTENT: dict[str, Callable[[bytes, int], bytes]] = {"": lambda data, _: data, "zstd": of_zstd, "lz4": _lz4}
"""Decompression of data to a size [bytes], by kind."""
