# SPDX-License-Identifier: Apache-2.0
"""Invariance under rotation about the axis of the hole and under reflection."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.scene import Scene
from drill_twin.scene.set_points.command import Command
from drill_twin_evidence.verify.case import FORMS, case
from drill_twin_evidence.verify.row import Row
from drill_twin_evidence.verify.scenes import ROLLING, WALLED, quiet_scene

SYMMETRY = "symmetry"


def whirling_scene(form: str = "spatial", **effects: Any) -> Scene:
    """A rod that whirls into the wall and rubs there within a second."""
    return quiet_scene(ROLLING | effects, of=WALLED, radius=0.04, step=2e-3, elements=16, form=form, tolerance=1e-6)


def rotated_run(
    scene: Scene, angle: float, *, mirror: bool = False, load: float = 40.0, speed: float = 12.0, seconds: float = 1.0
) -> Array:
    """Centre line after a run whose initial state is rotated by an angle, in axes rotated by that angle.

    Args:
        scene: The scene.
        angle: Rotation of the initial state about the axis of the hole [rad].
        mirror: Start from the mirror image and rotate the other way.
        load: Weight on bit at the end [N]; it grows from the start.
        speed: Rotation at the end [rad/s].
        seconds: Simulated time [s].

    Returns:
        Lateral positions [m], shape (n + 1, 2).
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
    """Bowed, damped rod that hits the wall and rubs there, from an initial state that is rotated about the axis of the
    hole, or mirrored with the opposite rotation.

    Newton's method stops at 1e-6 of the radius of the rod, 1e-8 m, in every step; contact amplifies that.
    """
    scene = whirling_scene(form)
    straight = rotated_run(scene, 0.0)
    for what, other in (
        ("start turned by 0.7 rad", rotated_run(scene, 0.7)),
        ("start turned by -2.5 rad", rotated_run(scene, -2.5)),
        ("mirror image", rotated_run(scene, 0.0, mirror=True)),
    ):
        yield Row(f"{what}: largest change of the centre line [m]", "0", SYMMETRY, 0.0,
                  float(np.abs(other - straight).max()), 1e-6, relative=False)  # fmt: skip
    yield Row("largest displacement [m], so that there is contact", "the clearance", "geometry", 0.04 - 0.00825,
              float(np.hypot(*straight.T).max()), 0.1)  # fmt: skip
