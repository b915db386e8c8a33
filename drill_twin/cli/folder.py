# SPDX-License-Identifier: Apache-2.0
"""Folders and files of results: an existing result is moved aside or replaced only with `--replace`."""

from __future__ import annotations

import re
from pathlib import Path

from drill_twin.core.errors import BagError
from drill_twin.core.files import result_folder
from drill_twin.core.files.whole_file import write_whole


def new_folder(folder: Path, *, replace: bool) -> Path | None:
    """Make an empty folder, as `result_folder.new_folder`; says on stderr where an older result is now."""
    moved = result_folder.new_folder(folder, replace=replace)
    if moved:
        from drill_twin.cli.show import remark

        remark(f"the older result is now {moved}")
    return moved


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
