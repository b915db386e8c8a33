# SPDX-License-Identifier: Apache-2.0
"""No direction across the hole is special, and no sense of turning."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from drill_twin.base.arrays import Array
from drill_twin.scene import Scene
from drill_twin.schedule.command import Command
from drill_twin.studies.verify.case import FORMS, case
from drill_twin.studies.verify.row import Row
from drill_twin.studies.verify.scenes import ROLLING, WALLED, quiet_scene
from drill_twin.twin.twin import Twin

SYMMETRY = "symmetry"


def lively(form: str = "spatial", **effects: Any) -> Scene:
    """A scene that whirls into the wall and rubs there within a second."""
    return quiet_scene(ROLLING | effects, of=WALLED, radius=0.04, step=2e-3, elements=16, form=form, tolerance=1e-6)


def turned(
    scene: Scene, angle: float, *, mirror: bool = False, load: float = 40.0, speed: float = 12.0, seconds: float = 1.0
) -> Array:
    """Centre line after a kicked, loaded, turning run, started at an angle and seen from that angle.

    Args:
        scene: What to run.
        angle: Of the start about the hole's axis [rad].
        mirror: Start from the mirror image and turn the other way.
        load: Weight on bit at the end [N]; it grows from the start.
        speed: Of rotation at the end [rad/s].
        seconds: How long.

    Returns:
        Lateral places [m], shape (n + 1, 2).
    """
    twin = Twin(scene)
    u, v = twin.unknowns
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    if mirror:
        turn = turn @ np.diag([1.0, -1.0])
    for rows in (u, v):
        rows[:, 0:2] = rows[:, 0:2] @ turn.T
        rows[:, 3:5] = rows[:, 3:5] @ turn.T
    u[:, 6] += angle
    sense = -1.0 if mirror else 1.0
    frames = round(seconds / 0.01)
    for k in range(frames):
        share = (k + 1) / frames
        frame = twin.advance(Command(weight_on_bit=load * share, rotation=sense * speed * share), 0.01)
    places: Array = frame.positions[:, :2] @ turn
    return places


@case(forms=FORMS)
def invariance(form: str) -> Iterator[Row]:
    """A bowed, damped rod is kicked into the wall and rubs there, from a start that is turned about the hole's axis, or
    mirrored and turning the other way.

    Newton's method stops at 1e-6 of the rod's radius, 1e-8 m, in every step; contact makes more of that.
    """
    scene = lively(form)
    straight = turned(scene, 0.0)
    for what, other in (
        ("start turned by 0.7 rad", turned(scene, 0.7)),
        ("start turned by -2.5 rad", turned(scene, -2.5)),
        ("mirror image", turned(scene, 0.0, mirror=True)),
    ):
        yield Row(f"{what}: largest change of the centre line [m]", "0", SYMMETRY, 0.0,
                  float(np.abs(other - straight).max()), 1e-6, relative=False)  # fmt: skip
    yield Row("largest displacement [m], so that there is contact", "the clearance", "geometry", 0.04 - 0.00825,
              float(np.hypot(*straight.T).max()), 0.1)  # fmt: skip
