# SPDX-License-Identifier: Apache-2.0
"""Habits of multibody codes, each alone on the bench as calibrated: which of them move the numbers."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin_evidence.paper.runs.cases import Case
from drill_twin_evidence.paper.search.evaluate import Bench, failed
from drill_twin_evidence.paper.search.readings import BASE
from drill_twin_evidence.paper.search.space import trial_of_scene

CASES = tuple(Case(load, 2.0) for load in (20.0, 40.0, 150.0, 300.0))
ELEMENTS = 20
FRICTION = "effects.wall_friction."
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
    "friction joined at 0.1 and 1 m/s, from 0.308 to a third": {
        FRICTION + "static_speed": 0.1, FRICTION + "dynamic_speed": 1.0, FRICTION + "decay": 0.0,
        FRICTION + "sliding": 0.308 / 3.0,
    },
    "friction joined at 0.1 and 1 m/s, from 0.5 to 0.1": {
        FRICTION + "static_speed": 0.1, FRICTION + "dynamic_speed": 1.0, FRICTION + "decay": 0.0,
        FRICTION + "coefficient": 0.5, FRICTION + "sliding": 0.1,
    },
}  # fmt: skip
"""Changes of the bench by name, in SI."""


class Habit(NamedTuple):
    """Findings of the bench with a habit."""

    name: str
    times: Array
    """Critical time at each of `CASES` [s]."""
    whirls: Array
    """Precession of mark_2 [Hz]."""
    sizes: Array
    """Largest displacement of mark_1, mark_2, mark_3 at 40 N [mm]."""

    def to_dict(self) -> dict[str, Any]:
        """Plain types for JSON."""
        return {"name": self.name, **{key: getattr(self, key).tolist() for key in ("times", "whirls", "sizes")}}


def habits(bench: Bench) -> list[Habit]:
    """The bench with each habit."""
    found = []
    one = trial_of_scene(bench.scene)
    for name, changes in HABITS.items():
        own = {"numerics.elements": ELEMENTS, **changes}
        runs = [bench.run(one, case, own) or failed() for case in CASES]
        times = np.array([run.time[BASE["time"]] for run in runs])
        whirls = np.array([run.whirl[BASE["whirl"]] for run in runs])
        found.append(Habit(name, times, whirls, 1e3 * runs[1].size[:, BASE["size"]]))
    return found
