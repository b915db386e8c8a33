# SPDX-License-Identifier: Apache-2.0
"""Orders of convergence."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.scene.set_points.command import Command
from drill_twin_evidence.verify.case import FORMS, case
from drill_twin_evidence.verify.row import TWIN, Row
from drill_twin_evidence.verify.scenes import quiet_scene
from drill_twin_evidence.verify.signals import convergence_order


def middle_path(elements: int, step: float, form: str) -> Array:
    """Path of mid-span over half a second after an initial velocity, under a growing load [m]; every 10 ms, (50, 2)."""
    effects = {
        "lateral_kick": {"velocity": 0.3, "shape": "hump"},
        "internal_damping": {"bending_time": 0.0, "stretch_time": 5e-3},
    }
    twin = Twin(quiet_scene(effects, elements=elements, step=step, form=form))
    frames = [twin.advance(Command(weight_on_bit=0.6 * (k + 1), rotation=0.0), 0.01) for k in range(50)]
    return np.array([frame.marks.centre[0, [0, 2]] for frame in frames])


def errors(paths: list[Array], reference: Array) -> list[float]:
    """Largest distance from the reference path, over its largest coordinate [-]."""
    return [float(np.abs(path - reference).max() / np.abs(reference).max()) for path in paths]


@case(forms=FORMS)
def in_space(form: str) -> Iterator[Row]:
    """Paths with 8, 12, 16 and 24 elements against 96, at a step of 1 ms.

    On such coarse meshes the order is not yet asymptotic.
    """
    counts = [8, 12, 16, 24]
    found = errors([middle_path(count, 1e-3, form) for count in counts], middle_path(96, 1e-3, form))
    yield Row("order in space [-]", "error ~ h^4 of cubic elements", "Strang and Fix 1973, ch. 4", 4.0,
              convergence_order([1.0 / count for count in counts], found), 0.2, relative=False)  # fmt: skip
    yield Row(
        "error at 24 elements, of the path [-]",
        "small",
        f"{TWIN}a run with more elements",
        0.0,
        found[-1],
        1e-4,
        relative=False,
    )


@case(forms=FORMS)
def in_time(form: str) -> Iterator[Row]:
    """Paths with steps of 5, 2.5 and 1.25 ms against 0.2 ms, with 16 elements.

    At the longest step the order is not yet asymptotic.
    """
    steps = [5e-3, 2.5e-3, 1.25e-3]
    found = errors([middle_path(16, step, form) for step in steps], middle_path(16, 2e-4, form))
    yield Row("order in time [-]", "error ~ dt^2 of the midpoint rule", "Hairer, Lubich and Wanner 2006, ch. II", 2.0,
              convergence_order(steps, found), 0.15, relative=False)  # fmt: skip
