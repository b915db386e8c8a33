# SPDX-License-Identifier: Apache-2.0
"""The comparison in one table, for the README."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from benchmarks.peers.parts import EXUDYN, MUJOCO, OURS, PYELASTICA
from benchmarks.peers.tables import remark, speed

TOOLS = (OURS, EXUDYN, MUJOCO, PYELASTICA)
NAMES = {OURS: "drill_twin", EXUDYN: "Exudyn (ANCF)", MUJOCO: "MuJoCo (flex)", PYELASTICA: "PyElastica"}
Row = Mapping[str, Any]


def summary(results: Sequence[Row]) -> str:
    """Markdown: a line for each question, a column for each tool that was run."""
    parts = {result["part"]: result["rows"] for result in results}
    tools = [tool for tool in TOOLS if any(row["tool"] == tool for rows in parts.values() for row in rows)]
    lines = [
        ("what", *(NAMES[tool] for tool in tools)),
        ("---", *("---:" for _ in tools)),
        *_lines(parts, tools),
        ("torsion", *("no" if tool == EXUDYN else "yes" for tool in tools)),
    ]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines) + "\n"


def _lines(parts: Mapping[str, Sequence[Row]], tools: Sequence[str]) -> list[tuple[str, ...]]:
    questions: list[tuple[str, str, Callable[[Sequence[Row]], str]]] = [
        ("smooth motion, error 1e-3: CPU s per s", "smooth", lambda rows: cheapest(rows, 1e-3)),
        ("smooth motion, error 1e-4: CPU s per s", "smooth", lambda rows: cheapest(rows, 1e-4)),
        ("buckled, error 1e-3: CPU s per s", "buckled", lambda rows: cheapest(rows, 1e-3)),
        ("wall and friction, error 1e-3 up to first contact: x real time", "contact", lambda rows: fastest(rows, 1e-3)),
        ("the same, 50 elements and 1 ms: x real time (error)", "contact", lambda rows: at(rows, 50, 1.0)),
        ("the same, 200 elements and 1 ms: x real time (error)", "contact", lambda rows: at(rows, 200, 1.0)),
        ("300 N, 6.5 rev/s, 50 elements: x real time (step)", "hard", ended),
        ("500 m of steel: x real time (elements)", "steel", largest),
    ]
    return [
        (question, *(answer(_of(parts[part], tool)) for tool in tools))
        for question, part, answer in questions
        if part in parts
    ]


def _of(rows: Sequence[Row], tool: str) -> list[Row]:
    return [row for row in rows if row["tool"] == tool and row["scene"] in {"peers", "steel"} and not row["plain"]]


def _good(rows: Sequence[Row], error: float) -> list[Row]:
    return [row for row in rows if row["error"] is not None and row["error"] <= error and not row["failure"]]


def best(rows: Sequence[Row]) -> str:
    """The smallest error, where the wanted one was not reached."""
    errors = [row["error"] for row in rows if row["error"] is not None and not row["failure"]]
    return f"{min(errors):.0e} at best" if errors else "none ended"


def cheapest(rows: Sequence[Row], error: float) -> str:
    """Least processor time for an error."""
    return min((f"{row['cost']:.2g}" for row in _good(rows, error)), key=float, default=best(rows))


def fastest(rows: Sequence[Row], error: float) -> str:
    """Largest real-time factor for an error."""
    costs = [row["cost"] for row in _good(rows, error)]
    return speed(1.0 / min(costs)) if costs else best(rows)


def at(rows: Sequence[Row], elements: int, step: float) -> str:
    """Real-time factor and error at one resolution; an explicit tool takes the largest step it survives."""
    fits = [row for row in rows if row["elements"] == elements]
    exact = [row for row in fits if row["step_ms"] and 0.7 * step < row["step_ms"] < 1.3 * step]
    chosen = exact or [row for row in fits if row["tool"] == PYELASTICA]
    whole = [row for row in chosen if not row["failure"]]
    if not whole:
        return remark(chosen[-1]) if chosen else "not run"
    row = whole[0]
    return f"{speed(1.0 / row['cost'])} ({row['error']:.0e})"


def ended(rows: Sequence[Row]) -> str:
    """Real-time factor of the finest run that ended, or why none did."""
    whole = [row for row in rows if not row["failure"]]
    if not whole:
        return remark(rows[-1]) if rows else "not run"
    row = min(whole, key=lambda row: row["step_ms"])
    return f"{speed(1.0 / row['cost'])} ({row['step_ms']:.2g} ms)"


def largest(rows: Sequence[Row]) -> str:
    """Real-time factor of the run with the most elements, or why it did not end."""
    if not rows:
        return "not run"
    row = max(rows, key=lambda row: row["elements"])
    return remark(row) or f"{speed(1.0 / row['cost'])} ({row['elements']})"
