# SPDX-License-Identifier: Apache-2.0
"""Output of a command: files in a folder, and on stdout JSON or a text for people.

An existing result is moved aside or replaced with `--replace` only.
"""

import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from rich.text import Text

from drill_twin.cli.show import out, print_json, remark
from drill_twin.core.errors import BagError
from drill_twin.core.files import output
from drill_twin.core.files.output import make_folder, write_whole, writing
from drill_twin.core.files.plain_json import json_text
from drill_twin.core.table import Table

Shown = Iterable[Table | Text | str]
"""Tables and lines for people; a generator computes them only where they are printed."""


def emit(
    data: Any,
    shown: Shown,
    *,
    json: bool,
    folder: Path | None = None,
    files: Mapping[str, Any] | None = None,
    also: Sequence[str] = (),
) -> None:
    """Write the files of a command, print its result, and name the files on stderr.

    The result is printed even if a file cannot be written.

    Args:
        data: Plain types, printed with `--json`.
        shown: Printed without it.
        json: Value of `--json`.
        folder: Folder of the files; None: none are written.
        files: Content by name, see `write_files`.
        also: Names of what is in the folder already.

    Raises:
        BagError: A file cannot be written.
    """
    names: Sequence[str] = ()
    try:
        if folder is not None:
            names = write_files(folder, files or {})
    finally:
        if json:
            print_json(data)
        else:
            for part in shown:
                say(part)
    if folder is not None:
        remark(f"{folder}: {', '.join([*names, *also])}")
    elif files:
        remark(f"no file was written; --out DIR writes {', '.join(files)}")


def say(part: Table | Text | str) -> None:
    """Print a table or a line on stdout."""
    if isinstance(part, Table):
        out().print(part)
    else:
        out().say(part)


def write_files(folder: Path, files: Mapping[str, Any]) -> Sequence[str]:
    """Write files, each as a whole or not at all.

    Args:
        folder: Folder of the files; made if there is none.
        files: By name a text, a matplotlib figure, or plain types, which become JSON; or a function that makes one.

    Returns:
        Their names.

    Raises:
        BagError: One cannot be written.
    """
    make_folder(folder)
    for name, given in files.items():
        content = given() if callable(given) else given
        if hasattr(content, "savefig"):
            from drill_twin.report.figures.style import save

            save(content, folder / name)
        else:
            write_file(folder / name, content if isinstance(content, str) else json_text(content))
    return list(files)


def new_folder(folder: Path, *, replace: bool) -> Path | None:
    """Make an empty folder, as `output.new_folder`; says on stderr where an older result is now."""
    if moved := output.new_folder(folder, replace=replace):
        remark(f"the older result is now {moved}")
    return moved


def check_new(file: Path, *, replace: bool) -> None:
    """Check that a file may be written.

    Raises:
        BagError: The file exists, and `replace` is off or the path is no file.
    """
    if file.exists() and not (replace and file.is_file()):
        raise BagError(f"{file}: expected a new file, found an existing file; choose another, or --replace")


def write_file(file: Path, content: bytes | str) -> None:
    """Write a file as a whole or not at all, and its folders.

    Raises:
        BagError: The file cannot be written.
    """
    with writing(file, "the file", "choose another place"):
        file.parent.mkdir(parents=True, exist_ok=True)
        write_whole(file, content)


def folder_name(text: str) -> str:
    """Valid name of a folder, from any text."""
    return re.sub(r"[^\w.-]+", "_", text).strip("._") or "run"
