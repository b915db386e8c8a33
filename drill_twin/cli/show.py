# SPDX-License-Identifier: Apache-2.0
"""Output in a terminal: tables on stdout, progress on stderr."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from rich import box
from rich.console import Console
from rich.segment import Segment
from rich.table import Table
from rich.text import Text

from drill_twin.core.errors import printable
from drill_twin.studies.json_io import json_text


class _PrintableConsole(Console):
    """Console that writes control characters out, whichever name of a bag they come from."""

    def _render_buffer(self, buffer: Iterable[Segment]) -> str:
        return super()._render_buffer(
            segment if segment.control else Segment(printable(segment.text), segment.style) for segment in buffer
        )


def out() -> Console:
    """Console for results, on stdout."""
    return _PrintableConsole(highlight=False)


def err() -> Console:
    """Console for progress and remarks, on stderr."""
    return _PrintableConsole(stderr=True, highlight=False)


def print_json(value: Any) -> None:
    """Print JSON on stdout."""
    print(json_text(value), end="")


def pairs(rows: Iterable[tuple[str, str]]) -> Table:
    """Table of names and values, without lines."""
    table = Table(show_header=False, box=None, padding=(0, 2, 0, 0))
    table.add_column(style="bold", no_wrap=True)
    for name, value in rows:
        table.add_row(*(Text(printable(cell, keep="")) for cell in (name, value)))
    return table


def grid(columns: Sequence[str], rows: Iterable[Sequence[str]], *, title: str = "", right: Sequence[int] = ()) -> Table:
    """Table with headings; the columns in `right` are aligned to the right."""
    table = Table(box=box.SIMPLE_HEAD, title=title or None, title_justify="left", padding=(0, 1), pad_edge=False)
    for number, column in enumerate(columns):
        table.add_column(column, justify="right" if number in right else "left", overflow="fold")
    for row in rows:
        table.add_row(*(Text(printable(cell, keep="")) for cell in row))
    return table


def print_findings(summary: Mapping[str, Any]) -> None:
    """Print a summary as tables: findings, marks, timeline and notes."""
    from drill_twin.report.text import findings, limitations, provenance

    console = out()
    console.print(pairs([*_without_radii(findings(summary)), *provenance(summary)]))
    if marks := list(_marks(summary)):
        heads = ("mark", "largest radius", "over the threshold", "motion at the end")
        console.print(grid(heads, marks, right=(2,)))
    if periods := [
        (f"{period['start_s']:.2f} s", f"{period['end_s']:.2f} s", period["state"], period["criterion"])
        for period in summary["motion"]
    ]:
        console.print(grid(("from", "to", "motion of the string", "what decided it"), periods, right=(0, 1)))
    for trouble in limitations(summary):
        err().print(Text(f"note: {trouble}", style="yellow"), soft_wrap=True)


def _without_radii(rows: Iterable[tuple[str, str]]) -> list[tuple[str, str]]:
    return [row for row in rows if not row[0].startswith("largest radius")]


def _marks(summary: Mapping[str, Any]) -> Iterable[tuple[str, str, str, str]]:
    from drill_twin.report.text import radius_text

    for mark, value in summary["max_radius_m"].items():
        onset, motion = summary["mark_onset_s"].get(mark), summary["mark_motion"].get(mark)
        yield (
            mark,
            radius_text(value, summary["clearance_m"].get(mark)),
            "never" if onset is None else f"from {onset:.2f} s",
            motion[-1]["state"] if motion else "unknown",
        )
