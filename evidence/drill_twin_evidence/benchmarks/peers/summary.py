# SPDX-License-Identifier: Apache-2.0
"""The comparison in one table, as in docs/peers.md."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from drill_twin.core.table import Table
from drill_twin_evidence.benchmarks.peers.parts import EXUDYN, MUJOCO, OURS, PYELASTICA
from drill_twin_evidence.benchmarks.peers.tables import remark, speed

TOOLS = (OURS, EXUDYN, MUJOCO, PYELASTICA)
NAMES = {OURS: "drill_twin", EXUDYN: "Exudyn (ANCF)", MUJOCO: "MuJoCo (flex)", PYELASTICA: "PyElastica"}
Row = Mapping[str, Any]


Answer = tuple[str, ...]


def summary(results: Sequence[Row]) -> str:
    """Markdown: a line for each measure of a case, a column for each tool that was run."""
    parts = {result["part"]: result["rows"] for result in results}
    tools = [tool for tool in TOOLS if any(row["tool"] == tool for rows in parts.values() for row in rows)]
    columns = ("case", "measure", *(NAMES[tool] for tool in tools))
    rows = [*_lines(parts, tools), ("torsion", "", *("no" if tool == EXUDYN else "yes" for tool in tools))]
    return Table(columns, rows, right=range(2, len(columns))).markdown() + "\n"


def _lines(parts: Mapping[str, Sequence[Row]], tools: Sequence[str]) -> list[tuple[str, ...]]:
    cost, factor, error = "CPU s per simulated s", "x real time", "error"
    cases: list[tuple[str, str, Answer, Callable[[Sequence[Row]], Answer]]] = [
        ("smooth motion", "smooth", (cost, error), lambda rows: cost_and_error(chosen(rows, 1e-4))),
        ("buckled by 40 N", "buckled", (cost, error), lambda rows: cost_and_error(chosen(rows, 1e-3))),
        ("wall and friction, to the first contact", "contact", (factor, error),
         lambda rows: speed_and_error(chosen(rows, 1e-3))),
        ("the same, 50 elements and 1 ms (PyElastica: 5 us)", "contact", (factor, error),
         lambda rows: speed_and_error(at(rows, 50, 1.0))),
        ("300 N, 6.5 rev/s, 50 elements", "hard", (factor,), lambda rows: (ended(rows),)),
        ("500 m of steel", "steel", ("x real time (elements)",), lambda rows: (largest(rows),)),
    ]  # fmt: skip
    lines = []
    for case, part, measures, answer in cases:
        if part in parts:
            answers = [answer(_of(parts[part], tool)) for tool in tools]
            for place, measure in enumerate(measures):
                lines.append(("" if place else case, measure, *(given[place] for given in answers)))
    return lines


def _of(rows: Sequence[Row], tool: str) -> list[Row]:
    return [row for row in rows if row["tool"] == tool and row["scene"] in {"peers", "steel"} and not row["plain"]]


def _good(rows: Sequence[Row], error: float) -> list[Row]:
    return [row for row in rows if row["error"] is not None and row["error"] <= error and not row["failure"]]


def chosen(rows: Sequence[Row], error: float) -> Row | None:
    """The cheapest run of at most an error; the most accurate one if there is none."""
    if good := _good(rows, error):
        return min(good, key=lambda row: row["cost"])
    return min(_good(rows, math.inf), key=lambda row: row["error"], default=None)


def at(rows: Sequence[Row], elements: int, step: float) -> Row | None:
    """The run at one resolution; an explicit tool takes the largest step at which it ends."""
    fits = [row for row in rows if row["elements"] == elements and not row["failure"]]
    exact = [row for row in fits if row["step_ms"] and 0.7 * step < row["step_ms"] < 1.3 * step]
    return next(iter(exact or [row for row in fits if row["tool"] == PYELASTICA]), None)


def cost_and_error(row: Row | None) -> Answer:
    """Processor seconds per simulated second, and error."""
    return ("none ended", "") if row is None else (f"{row['cost']:.2g}", f"{row['error']:.1e}")


def speed_and_error(row: Row | None) -> Answer:
    """Real-time factor, and error."""
    return ("none ended", "") if row is None else (speed(1.0 / row["cost"]), f"{row['error']:.1e}")


def ended(rows: Sequence[Row]) -> str:
    """Real-time factor of the finest run that ended, or why none did."""
    whole = [row for row in rows if not row["failure"]]
    if not whole:
        return remark(rows[-1]) if rows else "not run"
    row = min(whole, key=lambda row: row["step_ms"])
    return speed(1.0 / row["cost"])


def largest(rows: Sequence[Row]) -> str:
    """Real-time factor of the run with the most elements, or why it did not end."""
    if not rows:
        return "not run"
    row = max(rows, key=lambda row: row["elements"])
    return remark(row) or f"{speed(1.0 / row['cost'])} ({row['elements']})"
