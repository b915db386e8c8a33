# SPDX-License-Identifier: Apache-2.0
"""Files that are written as a whole: on a full disk, or after a kill, the file of before is there, or none."""

from __future__ import annotations

import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from errno import EINVAL
from pathlib import Path
from typing import BinaryIO

PRIVATE = 0o600
"""Mode of a file that only its owner reads and writes."""


def write_whole(path: Path, content: bytes | str, mode: int = 0o666) -> None:
    """Write a file as a whole or not at all; a text in UTF-8. Mode and errors are those of `whole_file`."""
    with whole_file(path, mode) as stream:
        stream.write(content.encode() if isinstance(content, str) else content)


@contextmanager
def whole_file(path: Path, mode: int = 0o666) -> Iterator[BinaryIO]:
    """Binary stream whose content takes the place of a file when the block has ended without an error.

    It is written to a temporary file beside it, flushed to the disk, and renamed. A link stays, and leads to the new
    file.

    Args:
        path: The file; its folder exists.
        mode: Permissions of the file, less those that the umask takes, or that the file of before has not.

    Raises:
        OSError: It cannot be written, or there is a folder, a pipe or a device in its place.
    """
    target = path.resolve()
    if target.exists():
        before = target.stat().st_mode
        if not stat.S_ISREG(before):
            raise OSError(EINVAL, "a folder, a pipe or a device there, which is not replaced")
        mode &= before
    part = target.with_name(f"{target.name[:200]}.{os.getpid()}.{os.urandom(4).hex()}.part")
    try:
        with os.fdopen(os.open(part, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, mode), "wb") as stream:
            yield stream
            stream.flush()
            os.fsync(stream.fileno())
        part.replace(target)
    except BaseException:
        with suppress(OSError):
            part.unlink(missing_ok=True)
        raise
