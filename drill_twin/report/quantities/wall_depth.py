# SPDX-License-Identifier: Apache-2.0
"""Penetration of the wall in a run, beside what the static load of the scene gives."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from drill_twin.core.compile.jit import as_python
from drill_twin.core.errors import DrillTwinError
from drill_twin.dynamics.discretisation.discretise import discretise, tubes_of
from drill_twin.dynamics.discretisation.resolution import MOST
from drill_twin.dynamics.twin import state_judge
from drill_twin.dynamics.twin.state_bounds import bounds_of
from drill_twin.physics.effects.wall import parameters as wall_parameters
from drill_twin.physics.model.mesh import build_rod
from drill_twin.report.recording import Recording
from drill_twin.report.string_curve import along_hole, refined
from drill_twin.scene import Scene
from drill_twin.scene.set_points import extremes

SOFT = 0.1
"""Penetration over the clearance above which the motion depends on the stiffness of the wall."""
SHARES = np.array([0.0, 0.5 - np.sqrt(1.0 / 12.0), 0.5 + np.sqrt(1.0 / 12.0)])
"""Node and Gauss points of an element; the wall acts at the latter."""


def wall_depth(bag: Recording) -> dict[str, Any] | None:
    """Deepest Gauss point of the string in the wall, over the recorded poses; None without a wall or poses.

    Keys: `deepest_m` (0 without contact), its `distance_from_bit_m` and `time_s`, `clearance_m` there, and `static_m`:
    the depth under the largest weight on bit at rest (`state_judge.static_depth`); None for a record without its file.
    """
    if not bag.scene_known or bag.scene.effects.wall is None or bag.nodes < 2:
        return None
    scene, poses = bag.scene, bag.poses
    curves = along_hole(scene, refined(poses.position, poses.tangent, SHARES))
    steps = np.linalg.norm(np.diff(curves[0], axis=0), axis=1)
    up = np.concatenate(([0.0], np.cumsum(steps)))
    if not (np.isfinite(curves).all() and up[-1] > 0.0):  # poses that no run of this scene publishes
        return None
    up *= scene.length / up[-1]
    clearance = np.array([scene.clearance_at(float(place)) for place in up])
    depth = np.hypot(curves[..., 0], curves[..., 1]) - clearance
    depth[:, :: SHARES.size] = -np.inf  # nodes, which the wall does not act on
    instant, place = np.unravel_index(np.argmax(depth), depth.shape)
    return {
        "deepest_m": max(float(depth[instant, place]), 0.0),
        "distance_from_bit_m": float(up[place]),
        "time_s": float(bag.poses.time[instant]),
        "clearance_m": float(clearance[place]),
        "static_m": static_depth(scene),
    }


def static_depth(scene: Scene) -> float | None:
    """Depth under the largest weight on bit of the schedule, at rest [m]; None without a wall or the record's file."""
    block = scene.effects.wall
    if block is None:
        return None
    try:
        load = extremes(scene).weight_on_bit
    except DrillTwinError:  # the record of the rig is not at hand
        return None
    model = discretise(scene, build_rod(tubes_of(scene), MOST))
    bounds = bounds_of(scene, model, wall_parameters(block, model), lateral=False)
    return float(as_python(state_judge.static_depth)(bounds, load))


def soft_wall(found: dict[str, Any] | None) -> Iterator[str]:
    """Yield a note where the string went deep into the wall."""
    if found is None or found["deepest_m"] <= SOFT * found["clearance_m"]:
        return
    depth, share = found["deepest_m"], found["deepest_m"] / found["clearance_m"]
    at_rest = f", {found['static_m'] * 1e3:.2g} mm of it under its load at rest" if found["static_m"] else ""
    yield (
        f"the wall is soft for this motion: the string went {depth * 1e3:.3g} mm into it, {share:.0%} of the "
        f"clearance{at_rest}; radii and frequencies depend on its stiffness: compare with a stiffer `wall`"
    )
