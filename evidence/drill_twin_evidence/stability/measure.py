# SPDX-License-Identifier: Apache-2.0
"""Runs over time step and wall stiffness or damping: convergence, iterations and energy error."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from drill_twin.core.errors import RunError
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.scene.set_points import Command
from drill_twin_evidence.stability.bound import explicit_limit
from drill_twin_evidence.verify.scenes import WALLED, rod_scene

ELEMENTS, SECONDS, RADIUS = 16, 0.5, 0.03
STEPS = (1e-5, 1e-4, 5e-4, 1e-3, 2e-3, 5e-3, 1e-2, 2e-2, 5e-2)
"""Time steps [s]."""
WALLS = (1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e10, 1e12)
"""Stiffness of a linear wall [N/m2]."""
TIMES = (1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1, 1.0, 10.0)
"""Retardation time of bending [s]."""
HERTZ = 20.0
"""Frames per second [Hz]."""


@dataclass(frozen=True)
class Cell:
    """Result of one run."""

    step: float
    """Nominal time step [s]."""
    value: float
    """Stiffness of the wall [N/m2] or retardation time [s]."""
    followed: bool
    """True if the run reached its end."""
    iterations: float
    """Newton iterations per step [-]."""
    cut: float
    """Steps halved, after failed convergence or by the step guard, per step [-]."""
    energy: float
    """Largest energy error, over the energy in motion [-]."""
    limit: float
    """Stability limit of an explicit scheme [s]."""


def measure(step: float, *, wall: float = 1e6, damping_time: float = 0.0) -> Cell:
    """Run of the rotating rod for half a second, after a lateral velocity towards the wall of a narrow hole.

    Args:
        step: Nominal time step [s].
        wall: Stiffness of a linear wall [N/m2].
        damping_time: Retardation time of bending [s].
    """
    effects: dict[str, Any] = {
        **WALLED,
        "gravity": {},
        "internal_damping": {"bending_time": damping_time},
        "wall": {"linear_stiffness": wall, "restitution": 1.0},
        "wall_friction": {"coefficient": 0.2},
        "lateral_kick": {"velocity": 0.5, "shape": "hump"},
    }
    scene = rod_scene(
        effects=effects, elements=ELEMENTS, step=step, form="lateral", radius=RADIUS, frame_rate=HERTZ,
    )  # fmt: skip
    twin = Twin(scene.model_copy(update={"numerics": scene.numerics.model_copy(update={"audit": "energy"})}))
    steps = iterations = cut = 0
    energy, followed = 0.0, True
    try:
        for _ in range(round(SECONDS * HERTZ)):
            frame = twin.advance(Command(0.0, 6.0), 1.0 / HERTZ)
            steps += frame.stats.steps
            iterations += frame.stats.iterations
            cut += frame.stats.cut_steps + (frame.intervention is not None)
            energy = max(energy, abs(frame.energy.share) if frame.energy else 0.0)
    except RunError:
        followed = False
    limit = explicit_limit(twin.rod, wall=wall, damping_time=damping_time)
    value = damping_time or wall
    return Cell(step, value, followed, iterations / max(steps, 1), cut / max(steps, 1), energy, limit)


def stability_map(
    what: str,
    *,
    steps: Sequence[float] = STEPS,
    values: Sequence[float] | None = None,
    progress: Callable[[Cell], None] = lambda _: None,
) -> list[list[Cell]]:
    """Results over steps and values of `wall` or `damping_time`: a row for each value."""
    chosen = values if values is not None else (WALLS if what == "wall" else TIMES)
    rows = []
    for value in chosen:
        row = []
        for step in steps:
            row.append(measure(step, **{what: value}))
            progress(row[-1])
        rows.append(row)
    return rows
