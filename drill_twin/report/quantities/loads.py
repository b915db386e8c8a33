# SPDX-License-Identifier: Apache-2.0
"""Hookload, torque and drag of a run: mean, least and largest."""

from __future__ import annotations

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.dynamics.discretisation.discretise import discretise, tubes_of
from drill_twin.dynamics.discretisation.initial_state import axial_weight
from drill_twin.dynamics.discretisation.resolution import MOST
from drill_twin.physics.model.mesh import build_rod
from drill_twin.report.recording import Recording
from drill_twin.scene import Scene

KEYS = ("weight_on_bit_n", "hookload_n", "top_drive_torque_nm", "bit_torque_nm", "drag_n")


def loads(bag: Recording) -> dict[str, dict[str, float] | None]:
    """Statistics over the whole recording, None for what the bag does not hold.

    Keys: `weight_on_bit_n`, `hookload_n`, `top_drive_torque_nm`, `bit_torque_nm` (of the rock on the bit, negative with
    right-handed rotation), as on `/rig/state`, and `drag_n`: hookload plus weight on bit less the weight of the string
    along the hole, which is the axial friction and inertia; positive = against motion upwards.
    """
    if not len(bag.rig):
        return dict.fromkeys(KEYS)
    rig = bag.rig
    weight = string_weight(bag.scene) if bag.scene_known else np.nan
    drag = rig.hookload + rig.bit_force - weight
    series = (rig.bit_force, rig.hookload, rig.top_drive_torque, rig.bit_torque, drag)
    return {key: _statistics(values) for key, values in zip(KEYS, series, strict=True)}


def applied(bag: Recording) -> dict[str, dict[str, float] | None]:
    """Statistics of weight on bit [N] and rotation of the top drive [rad/s] over the second half of the recording."""
    rig = bag.rig
    if not len(rig):
        return {"weight_on_bit_n": None, "rotation_rad_s": None}
    late = rig.time >= 0.5 * (rig.time[0] + rig.time[-1])
    return {
        "weight_on_bit_n": _statistics(rig.bit_force[late]),
        "rotation_rad_s": _statistics(rig.top_drive_speed[late]),
    }


def string_weight(scene: Scene) -> float:
    """Weight of the string along the hole, less buoyancy [N]; 0 without gravity."""
    return float(axial_weight(scene, discretise(scene, build_rod(tubes_of(scene), MOST))).sum())


def _statistics(values: Array) -> dict[str, float] | None:
    known = values[np.isfinite(values)]
    if not known.size:
        return None
    return {"mean": float(known.mean()), "min": float(known.min()), "max": float(known.max())}
