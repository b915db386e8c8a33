# SPDX-License-Identifier: Apache-2.0
"""New file that is written at its end only, and that notices what other programs do to it meanwhile."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path


class CheckedStream:
    """Binary stream to a new file; bytes that another program cuts off are not replaced by a hole.

    Raises:
        OSError: The file exists, or cannot be created or written.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_APPEND
        self._stream = os.fdopen(os.open(path, flags, 0o666), "ab")
        self._size = 0

    def write(self, data: bytes) -> int:
        """Append bytes."""
        self._size += len(data)
        return self._stream.write(data)

    def tell(self) -> int:
        """Number of bytes written so far."""
        return self._size

    def flush(self) -> None:
        """Pass everything to the operating system."""
        self._stream.flush()

    def close(self) -> None:
        """Close the file."""
        self._stream.close()

    def close_at(self, size: int) -> None:
        """Close the file after an error of the disk, without what was begun after a size [bytes]."""
        with suppress(OSError), os.fdopen(os.dup(self._stream.fileno()), "ab", buffering=0) as file:
            with suppress(OSError):  # fails for the same reason, or puts a part there
                self._stream.close()
            if file.tell() > size:
                file.truncate(size)

    def change(self) -> str:
        """Another program's change of the flushed file, as `found it removed`; empty if there is none."""
        size = os.fstat(self._stream.fileno()).st_size
        if size < self._size:
            return f"found it cut to {size} of {self._size} bytes"
        if size > self._size:
            return f"found {size - self._size} bytes of another program in it"
        try:
            there = self._path.stat()
        except OSError:
            return "found it removed"
        same = os.path.samestat(there, os.fstat(self._stream.fileno()))
        return "" if same else "found another file in its place"
