# SPDX-License-Identifier: Apache-2.0
"""Folders and files of results: an existing result is moved aside or replaced only with `--replace`."""

from __future__ import annotations

import re
from itertools import count
from pathlib import Path

from drill_twin.core.errors import BagError
from drill_twin.core.files.whole_file import write_whole

_RESULTS = ("bag_0", "summary.json", "report.html", "compare.json")


def new_folder(folder: Path, *, replace: bool) -> Path | None:
    """Make an empty folder; with `replace` an existing result is moved to `<folder>.old`, with a line on stderr.

    Returns:
        New path of the older result, if there was one.

    Raises:
        BagError: The folder is not empty, or cannot be made.
    """
    moved = None
    try:
        if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
            if not replace:
                raise BagError(
                    f"{folder}: expected a new or empty folder, found one with {_inside(folder)} in it; choose another "
                    "with --out, or --replace to move that aside"
                )
            moved = _move_aside(folder)
    except OSError as error:
        raise _not_writable(folder, error) from error
    make_folder(folder)
    if moved:
        from drill_twin.cli.show import remark

        remark(f"the older result is now {moved}")
    return moved


def make_folder(folder: Path) -> None:
    """Make a folder if it does not exist.

    Raises:
        BagError: The folder cannot be made.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise _not_writable(folder, error) from error


def check_new(file: Path, *, replace: bool) -> None:
    """Check that a file may be written.

    Raises:
        BagError: It exists, and `replace` is off or it is no file.
    """
    if file.exists() and not (replace and file.is_file()):
        raise BagError(f"{file}: expected a new file, found one that exists; choose another, or --replace")


def write_file(file: Path, text: str) -> None:
    """Write a text file as a whole or not at all, and its folders.

    Raises:
        BagError: The file cannot be written.
    """
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        write_whole(file, text)
    except OSError as error:
        raise BagError(f"{file}: cannot be written: {error.strerror or error}; choose another place") from error


def folder_name(text: str) -> str:
    """Valid name of a folder, from any text."""
    return re.sub(r"[^\w.-]+", "_", text).strip("._") or "run"


def _not_writable(folder: Path, error: OSError) -> BagError:
    return BagError(
        f"{folder}: expected a place to write the result, found {error.strerror or error}; choose another with --out"
    )


def _move_aside(folder: Path) -> Path:
    if folder.is_symlink() or not folder.is_dir() or not any((folder / name).exists() for name in _RESULTS):
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
