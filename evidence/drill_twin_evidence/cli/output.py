# SPDX-License-Identifier: Apache-2.0
"""Options and page of a study, for several commands."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Annotated, Any

import typer

from drill_twin.core.errors import ArgumentError, SceneError

EVIDENCE = Path(__file__).resolve().parents[2]
"""Folder `evidence/` of a clone."""


PageOption = Annotated[
    Path | None, typer.Option("--page", metavar="FILE", help="Write the table as a page (.md), and as JSON beside it.")
]
OnlyOption = Annotated[
    str,
    typer.Option("--only", metavar="TEXT", help="Run only the case of this name, or those that contain it."),
]
QuickOption = Annotated[bool, typer.Option("--quick", help="Leave out what takes long.")]
ListOption = Annotated[bool, typer.Option("--list", help="Print the names of the cases and what they are for.")]


def chosen(only: str, names: Iterable[str]) -> list[str]:
    """A name, or the names that contain a text, in which `*` is any text and `?` a letter.

    Raises:
        ArgumentError: None does.
    """
    known = list(names)
    if only in known:
        return [only]
    if found := [name for name in known if fnmatchcase(name, f"*{only.replace('[', '[[]')}*")]:
        return found
    raise ArgumentError(f'--only: expected a part of {", ".join(known)}, found "{only}"')


def check_any(cases: Sequence[object], only: str, command: str) -> None:
    """Check that a text chose a case.

    Raises:
        SceneError: It chose none.
    """
    if not cases:
        raise SceneError(
            f'--only: expected a part of the name of a case, found "{only}"; see drill-twin study {command} --list'
        )


@contextmanager
def told(title: str, count: int, of: Callable[[Any], tuple[str, str]]) -> Iterator[Callable[[Any], None]]:
    """Bar over cases; gives a function that steps it for a result, of which `of` gives the name and what is wrong."""
    from drill_twin.cli.show import remark, shown_progress

    with shown_progress(title, count) as bar:

        def done(result: Any) -> None:
            name, wrong = of(result)
            bar.step(name)
            if wrong:
                remark(f"{name}: {wrong}", "red")

        yield done


def write_page(
    page: Path, build: Callable[[str], str], data: Any, *, command: str, only: str, flags: Mapping[str, bool]
) -> None:
    """Write a page of results, and its data as JSON beside it.

    The data of a page in `evidence/docs/` go to `evidence/pages/`.

    Args:
        page: File of the page (.md).
        build: Makes the page from the command line that writes it.
        data: Plain types.
        command: Name of the command.
        only: Value of `--only`.
        flags: Flags of the command, and whether they are set.

    Raises:
        BagError: A file cannot be written.
    """
    from drill_twin.cli.emit import write_file
    from drill_twin.cli.show import remark
    from drill_twin.core.files.plain_json import json_text

    options = [*(["--only", only] if only else []), *(flag for flag, on in flags.items() if on)]
    write_file(page, build(" ".join(["drill-twin study", command, *options, "--page", page.as_posix()])))
    file = _data_file(page)
    write_file(file, json_text(data))
    remark(f"{page}, {file}")


def _data_file(page: Path) -> Path:
    beside = page.with_suffix(".json")
    in_docs = page.resolve().parent == EVIDENCE / "docs"
    return EVIDENCE / "pages" / beside.name if in_docs else beside
