# SPDX-License-Identifier: Apache-2.0
"""Output in a terminal: tables on stdout, progress on stderr."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from typing import Any

from rich.console import Console
from rich.segment import Segment

from drill_twin.core.errors import printable
from drill_twin.core.table import Table
from drill_twin.studies.json_io import json_text


class _PrintableConsole(Console):
    """Console that writes control characters out, whichever name of a bag they come from."""

    def _render_buffer(self, buffer: Iterable[Segment]) -> str:
        return super()._render_buffer(
            segment if segment.control else Segment(printable(segment.text), segment.style) for segment in buffer
        )


def out() -> Console:
    """Console for results, on stdout."""
    return _PrintableConsole(highlight=False, emoji=False)


@cache
def err() -> Console:
    """Console for progress and remarks, on stderr: the same one for all, so that remarks stay above a bar."""
    return _PrintableConsole(stderr=True, highlight=False, emoji=False)


def print_json(value: Any) -> None:
    """Print JSON on stdout."""
    print(json_text(value), end="")


def remark(text: str, style: str = "") -> None:
    """Print a line on stderr, as it is: above the bar of a progress that is shown."""
    err().print(text, style=style, markup=False, soft_wrap=True)


def findings_shown(summary: Mapping[str, Any]) -> Iterator[Table]:
    """Tables of a summary: findings, marks and timeline; what limits the findings goes to stderr."""
    from drill_twin.report.text import findings, limitations, provenance

    yield Table((), [*_without_radii(findings(summary)), *provenance(summary)])
    if marks := list(_marks(summary)):
        yield Table(("mark", "largest radius", "over the threshold", "motion at the end"), marks, right=(2,))
    if periods := [_period(period) for period in summary["motion"]]:
        yield Table(("from", "to", "motion of the string", "what decided it"), periods, right=(0, 1))
    for trouble in limitations(summary):
        remark(f"note: {trouble}", "yellow")


def marks_shown(summary: Mapping[str, Any]) -> Iterator[Table]:
    """Timeline of every mark."""
    motion = summary["mark_motion"].items()
    if rows := [(mark, *_period(period)) for mark, periods in motion for period in periods]:
        yield Table(("mark", "from", "to", "motion", "what decided it"), rows, right=(1, 2))


def _period(period: Mapping[str, Any]) -> tuple[str, str, str, str]:
    return f"{period['start_s']:.2f} s", f"{period['end_s']:.2f} s", period["state"], period["criterion"]


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
