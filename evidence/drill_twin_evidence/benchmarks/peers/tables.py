# SPDX-License-Identifier: Apache-2.0
"""The results as tables: in the terminal, and as Markdown for the pages."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from drill_twin.core.table import Column, Table

HEADS = (
    "tool",
    "elements",
    "step",
    "error",
    "mean rise",
    "CPU s per s",
    "x real time",
    "ns per element-step",
    "remarks",
)


def cells(row: Mapping[str, Any]) -> tuple[str, ...]:
    """A row in words."""
    cost, nanoseconds, rise = row["cost"], row["element_step_ns"], row["mean_rise_m"]
    name = row["tool"] if row["scene"] in {"peers", "steel"} else f"{row['tool']}, {row['scene']}"
    if row["plain"]:
        name += ", clamps as they come"
    return (
        name,
        str(row["elements"]),
        f"{row['step_ms']:.2g} ms" if row["step_ms"] else "",
        "" if row["error"] is None else f"{row['error']:.1e}",
        "" if row["error"] is not None or rise is None else f"{1e3 * rise:.1f} mm",
        "" if cost is None else f"{cost:.2g}",
        "" if cost is None else speed(1.0 / cost),
        "" if nanoseconds is None else f"{nanoseconds:,.0f}",
        remark(row),
    )


def speed(factor: float) -> str:
    """A real-time factor, two figures of it."""
    return f"{factor:.2g}" if factor < 100.0 else f"{float(f'{factor:.2g}'):,.0f}"


def remark(row: Mapping[str, Any]) -> str:
    """Reason why a run ended early, its first clause."""
    return str(row["failure"]).split(",", maxsplit=1)[0]


def table(result: Mapping[str, Any]) -> Table:
    """Table without columns that are empty throughout."""
    rows = [cells(row) for row in result["rows"]]
    used = [column for column in range(len(HEADS)) if any(row[column] for row in rows)]
    columns = [Column(HEADS[column], right=HEADS[column] not in {"tool", "remarks"}) for column in used]
    return Table(columns, [tuple(row[column] for column in used) for row in rows], title=result["title"])


def note(result: Mapping[str, Any]) -> str:
    """Reference that the errors are counted against."""
    if result["reference"] is None:
        return "mean rise: of the bottom, over the second half of what was run"
    until = f" up to first contact at {result['contact_s']:.2f} s" if result["contact_s"] else ""
    apart = f"; {result['check']} is {result['apart']:.0e} from it" if result["apart"] is not None else ""
    reference = f"{result['reference']}{until}"
    return f"error: largest distance of the mid-span path from {reference}, over its largest value{apart}"


def markdown(result: Mapping[str, Any]) -> str:
    """For a page."""
    return "\n".join([f"**{result['title']}**", "", table(result).markdown(), "", note(result), ""])
