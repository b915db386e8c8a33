# SPDX-License-Identifier: Apache-2.0
"""Files that are written whole or not at all, and folders of results, which are moved aside only where asked."""

import os
import stat
from collections.abc import Collection, Iterator
from contextlib import contextmanager, suppress
from errno import EINVAL
from itertools import count
from pathlib import Path
from typing import BinaryIO

from drill_twin.core.errors import BagError, DrillTwinError

PRIVATE = 0o600
"""Mode of a file that only its owner reads and writes."""


@contextmanager
def writing(
    place: object, what: str = "the result", remedy: str = "choose another with --out",
    error_type: type[DrillTwinError] = BagError,
) -> Iterator[None]:  # fmt: skip
    """Turn the OSError of a file or folder that cannot be written into one of ours, which says what to do.

    Args:
        place: Path that is written.
        what: Content that is written, in the message.
        remedy: End of the message.
        error_type: Raised for the OSError.
    """
    try:
        yield
    except OSError as error:
        raise error_type(
            f"{place}: expected a place to write {what}, found {error.strerror or error}; {remedy}"
        ) from error


def write_whole(path: Path, content: bytes | str, mode: int = 0o666) -> None:
    """Write a file as a whole or not at all; a text in UTF-8. Mode and errors as for `whole_file`."""
    with whole_file(path, mode) as stream:
        stream.write(content.encode() if isinstance(content, str) else content)


@contextmanager
def whole_file(path: Path, mode: int = 0o666) -> Iterator[BinaryIO]:
    """Binary stream whose content takes the place of a file when the block has ended without an error.

    The content is written to a temporary file beside the file, flushed to the disk, and renamed. A link
    stays, and leads to the new file.

    Args:
        path: The file; its folder exists.
        mode: Permissions of the file, less the permissions that the umask takes, or that the replaced file lacks.

    Raises:
        OSError: The file cannot be written, or there is a folder, a pipe or a device in its place.
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


RESULTS = ("bag_0", "summary.json", "report.html", "compare.json")
"""Names of entries by which a folder is known as the folder of a result."""


def new_folder(folder: Path, *, replace: bool, results: Collection[str] = RESULTS) -> Path | None:
    """Make an empty folder; with `replace` a result, known by an entry of `results`, is moved to `<folder>.old`.

    Returns:
        New path of the older result, if there was one.

    Raises:
        BagError: The folder is not empty, or cannot be made.
    """
    moved = None
    with writing(folder):
        if check_folder(folder, replace=replace):
            moved = _move_aside(folder, results)
    make_folder(folder)
    return moved


def check_folder(folder: Path, *, replace: bool) -> bool:
    """True for a folder that is not empty, which `new_folder` would move aside.

    Raises:
        BagError: The folder is not empty, and `replace` is False.
    """
    taken = folder.exists() and (not folder.is_dir() or any(folder.iterdir()))
    if taken and not replace:
        raise BagError(
            f"{folder}: expected a new or empty folder, found one with {_inside(folder)} in it; choose another "
            "with --out, or --replace to move that aside"
        )
    return taken


def make_folder(folder: Path) -> None:
    """Make a folder if it does not exist.

    Raises:
        BagError: The folder cannot be made.
    """
    with writing(folder):
        folder.mkdir(parents=True, exist_ok=True)


def _move_aside(folder: Path, results: Collection[str]) -> Path:
    if folder.is_symlink() or not folder.is_dir() or not any((folder / name).exists() for name in results):
        raise BagError(
            f"{folder}: expected the result of an earlier run to replace, found {_inside(folder)}; choose another with "
            "--out"
        )
    names = (f"{folder.name}.old{'' if number == 1 else number}" for number in count(1))
    target = next(place for name in names if not (place := folder.with_name(name)).exists())
    return folder.rename(target)


def _inside(folder: Path) -> str:
    if not folder.is_dir():
        return "a file"
    names = sorted(entry.name for entry in folder.iterdir())
    return ", ".join(names[:3]) + (" and more" if len(names) > 3 else "")
