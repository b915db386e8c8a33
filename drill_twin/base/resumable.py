# SPDX-License-Identifier: Apache-2.0
"""File of lines that a study writes as it goes: what it is of, then a line of JSON a result."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from drill_twin.errors import ArgumentError


def resume(
    file: Path, key: str, setup: Mapping[str, Any], read: Callable[[list[str]], None], *, foreign: str, other: str
) -> None:
    """Open a file of results, begin it if it is new, and cut off a last line that is not whole.

    Args:
        file: The file; it need not exist.
        key: Name of the setup in the first line.
        setup: All that the results depend on, in plain types.
        read: Takes the lines of results that it has, before anything is written.
        foreign: Message if the first line is no setup.
        other: Message if it is another one; `{}` stands for the names that differ.

    Raises:
        ArgumentError: The file is of another setup, or none of these files.
        OSError: It cannot be read or written.
    """
    file.parent.mkdir(parents=True, exist_ok=True)
    text = file.read_bytes() if file.exists() else b""
    whole = text[: text.rfind(b"\n") + 1]  # a line that was cut off is computed again
    lines = whole.decode("utf-8", "replace").splitlines()
    if lines:
        _check(file, lines[0], key, setup, foreign, other)
        read(lines[1:])
    with file.open("ab") as stream:
        stream.truncate(len(whole))
        if not whole:
            stream.write((json.dumps({key: setup}) + "\n").encode())


def _check(file: Path, line: str, key: str, setup: Mapping[str, Any], foreign: str, other: str) -> None:
    try:
        found = json.loads(line)[key]
    except (ValueError, KeyError, TypeError):
        raise ArgumentError(f"{file}: {foreign}") from None
    if differing := [name for name, value in setup.items() if found.get(name) != json.loads(json.dumps(value))]:
        raise ArgumentError(f"{file}: {other.format(' and '.join(differing))}")
