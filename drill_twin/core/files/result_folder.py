# SPDX-License-Identifier: Apache-2.0
"""Folders of results: an older result is moved aside only where that is asked for, and nothing else ever is."""

from __future__ import annotations

from collections.abc import Collection
from itertools import count
from pathlib import Path

from drill_twin.core.errors import BagError

RESULTS = ("bag_0", "summary.json", "report.html", "compare.json")
"""Names by which a folder is known as that of a result."""


def new_folder(folder: Path, *, replace: bool, results: Collection[str] = RESULTS) -> Path | None:
    """Make an empty folder; with `replace` a result, known by an entry of `results`, is moved to `<folder>.old`.

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
            moved = _move_aside(folder, results)
    except OSError as error:
        raise _not_writable(folder, error) from error
    make_folder(folder)
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


def _not_writable(folder: Path, error: OSError) -> BagError:
    return BagError(
        f"{folder}: expected a place to write the result, found {error.strerror or error}; choose another with --out"
    )


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
