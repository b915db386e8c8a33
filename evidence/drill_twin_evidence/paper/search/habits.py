# SPDX-License-Identifier: Apache-2.0
"""Habits of multibody codes, each alone on the bench as calibrated: which of them move the numbers."""

from __future__ import annotations

from typing import Any

from drill_twin.core.table import Table
from drill_twin_evidence.paper.runs.cases import Case
from drill_twin_evidence.paper.search.bench import Bench
from drill_twin_evidence.paper.search.readings import BASE, Readings
from drill_twin_evidence.paper.search.space import set_of

CASES = tuple(Case(load, 2.0) for load in (20.0, 40.0, 150.0, 300.0))
ELEMENTS = 20
FRICTION = "effects.wall_friction."
JOINED = {FRICTION + "static_speed": 0.1, FRICTION + "dynamic_speed": 1.0, FRICTION + "decay": 0.0}
HABITS: dict[str, dict[str, Any]] = {
    "as calibrated": {},
    "lumped: 5 elements": {"numerics.elements": 5},
    "lumped: 8 elements, as the search": {"numerics.elements": 8},
    "contact that loses nearly all: restitution 0.05": {"effects.wall.restitution": 0.05},
    "contact that loses hardly anything: restitution 0.95": {"effects.wall.restitution": 0.95},
    "contact 100 times as stiff": {"effects.wall.stiffness": 1e9},
    "contact 100 times as soft": {"effects.wall.stiffness": 1e5},
    # backward Euler damps a motion of the angular frequency w by w h / 2, as a drag of m w^2 h per length does
    "integrator's damping at 5 ms and 1.1 Hz, as drag": {"effects.drag.linear": 0.06},
    "friction joined at 0.1 and 1 m/s, from 0.308 to a third": {**JOINED, FRICTION + "sliding": 0.308 / 3.0},
    "friction joined at 0.1 and 1 m/s, from 0.5 to 0.1": {
        **JOINED, FRICTION + "coefficient": 0.5, FRICTION + "sliding": 0.1,
    },
}  # fmt: skip
"""Changes of the bench by name, in SI."""


def habits(bench: Bench) -> dict[str, list[Readings]]:
    """Readings at each of `CASES` of the bench with each habit."""
    wanted = [(set_of(bench.scene), case) for case in CASES]
    return {name: bench.run(wanted, {"numerics.elements": ELEMENTS} | keys) for name, keys in HABITS.items()}


def habit_table(found: dict[str, list[Readings]]) -> Table:
    """Critical times and whirls at each of `CASES`, and sizes at 40 N."""
    rows = [
        (name, ", ".join(f"{run.time[BASE['time']]:.2f}" for run in runs),
         ", ".join(f"{run.whirl[BASE['whirl']]:+.2f}" for run in runs),
         ", ".join(f"{1e3 * runs[1].size[mark][BASE['size']]:.0f}" for mark in ("mark_3", "mark_2", "mark_1")))
        for name, runs in found.items()
    ]  # fmt: skip
    columns = ("habit", "critical times, s", "whirl at 20, 40, 150, 300 N, Hz", "mark-3, -2, -1 at 40 N, mm")
    title = "The bench as calibrated, with a habit of multibody codes"
    return Table(columns, rows, title=title, right=(1, 2, 3))
