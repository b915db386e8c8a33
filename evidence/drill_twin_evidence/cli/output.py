# SPDX-License-Identifier: Apache-2.0
"""Progress bar and page of a study, for several commands."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.progress import Progress, TaskID

EVIDENCE = Path(__file__).resolve().parents[2]
"""Folder `evidence/` of a clone."""


def counting_bar(name: str, total: int | None = None) -> tuple[Progress, TaskID]:
    """Progress bar on stderr that counts runs, and its task; to be entered as a context."""
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    from drill_twin.cli.show import err

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    progress = Progress(*columns, console=err(), transient=True)
    return progress, progress.add_task(name, total=total)


def write_page(
    page: Path, build: Callable[[str], str], data: Any, *, command: str, only: str, flags: Mapping[str, bool]
) -> None:
    """Write a page of results, and its data as JSON beside it.

    The data of a page in `docs/` of the repository are part of the evidence: they go to `evidence/pages/`.

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
    from drill_twin.cli.folder import write_file
    from drill_twin.cli.show import err
    from drill_twin.studies.json_io import json_text

    options = [*(["--only", only] if only else []), *(flag for flag, on in flags.items() if on)]
    write_file(page, build(" ".join(["drill-twin", command, *options, "--page", page.as_posix()])))
    file = _data_file(page)
    write_file(file, json_text(data))
    err().print(f"{page}, {file}", markup=False, soft_wrap=True)


def _data_file(page: Path) -> Path:
    beside = page.with_suffix(".json")
    in_docs = page.resolve().parent == EVIDENCE.parent / "docs"
    return EVIDENCE / "pages" / beside.name if in_docs else beside
