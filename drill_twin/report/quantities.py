# SPDX-License-Identifier: Apache-2.0
"""Quantities of a recording for its summary: loads, fatigue, spectrum of the leading mark, depth in the wall."""

import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from drill_twin.core.arrays import Array, Mask
from drill_twin.core.compile.jit import as_python
from drill_twin.core.errors import DrillTwinError
from drill_twin.core.units.system import UnitSystem
from drill_twin.dynamics.discretisation.discretise import axial_weight, discretise, tubes_of
from drill_twin.dynamics.discretisation.joint import joint_of
from drill_twin.dynamics.discretisation.resolution import MOST
from drill_twin.dynamics.twin import state_judge
from drill_twin.dynamics.twin.binding import bounds_of
from drill_twin.io.bag.virtual_bags import RecordBag
from drill_twin.physics.effects.wall import parameters as wall_parameters
from drill_twin.physics.model.mesh import build_rod
from drill_twin.report.recording import Recording
from drill_twin.report.string_curve import along_hole, arc_of, refined
from drill_twin.scene import Scene
from drill_twin.scene.set_points import extremes
from drill_twin.whirl.motion.stick_slip_index import REST
from drill_twin.whirl.spectrum import lines_of


def settled_from(bag: Recording) -> float:
    """Time from which means are taken [s]: the middle, or the end of the scene's ramps where a quarter follows it."""
    time = bag.rig.time if len(bag.rig) else bag.marks.time
    if not len(time):
        return 0.0
    middle = 0.5 * float(time[0] + time[-1])
    rig = bag.scene.rig if bag.scene_known else None
    ramps = max(point.start + point.duration for point in (rig.weight_on_bit, rig.rotation)) if rig else 0.0
    return ramps if middle < ramps <= 0.5 * (middle + float(time[-1])) else middle


def fatigue(bag: Recording) -> dict[str, dict[str, float | None]] | None:
    """By section: stress, cycles and damage of the run; None without the effect.

    Keys: `distance_from_bit_m`, `largest_stress_pa` and its `share_of_yield`, `largest_moment_nm`, `cycles`, `damage`;
    and from `settled_from` on `axial_force_n` (mean, positive = tension), `cycles_per_second` and
    `seconds_to_damage_1`: the whole life at its rate of damage, None without any.
    """
    block = bag.scene.effects.fatigue if bag.scene_known else None
    if block is None or not len(bag.stress):
        return None
    found, strengths = bag.stress, block.yield_strengths(bag.scene)
    places = {section.name: section.distance(bag.scene.length) for section in block.sections}
    middle = min(int(np.searchsorted(found.time, settled_from(bag))), len(found.time) - 1)
    seconds = float(found.time[-1] - found.time[middle])
    moment = np.hypot(found.moment_x, found.moment_y).max(axis=0)
    rows = {}
    for number, name in enumerate(found.names):
        damage, cycles = found.damage[:, number], found.cycles[:, number]
        late = float(damage[-1] - damage[middle])
        largest = float(found.largest_stress[-1, number])
        rows[name] = {
            "distance_from_bit_m": places[name],
            "largest_stress_pa": largest,
            "share_of_yield": largest / strengths[name],
            "largest_moment_nm": float(moment[number]),
            "axial_force_n": float(found.axial_force[middle:, number].mean()),
            "cycles": float(cycles[-1]),
            "damage": float(damage[-1]),
            "cycles_per_second": float(cycles[-1] - cycles[middle]) / seconds if seconds > 0.0 else None,
            "seconds_to_damage_1": seconds / late if late > 0.0 else None,
        }
    return rows


SLIPS, FEWEST, HELD, LIGHT, SHARES, LARGEST, APART = 10.0, 4, 0.02, 0.05, (0.02, 0.25, 0.5), 95.0, 3.0
"""Least time [s] and samples in slips; hookload's variation then, weight on bit, and hookload (least, largest of one
time in slips, largest where slips recur) over the string's hookload, a percentile of the record; distance of two times
in slips over their length."""


def block_weight(bag: Recording, kept: Mapping[str, Array]) -> dict[str, Any] | None:
    """Weight of block and top drive, which the hookload of a record holds; None where no hookload is recorded.

    Keys: `weight_n`, given as `block_weight`, or the lowest hookload that is steady while the top drive rests and no
    weight is on the bit, as in slips, since `at_s` (None where given); NaN where neither is known. Above a quarter of
    the string's hookload, which may be a shorter string that hangs, it must recur.
    """
    if not isinstance(bag.bag, RecordBag) or (hookload := kept.get("hookload")) is None:
        return None
    time, largest, found = bag.rig.time, float(np.nanpercentile(hookload, LARGEST)), list[tuple[float, float]]()
    wide = max(SLIPS, 5.0 * float(np.median(np.diff(time))))
    load = np.abs(kept.get("bit_force", 0.0)) / (LIGHT * largest)
    busy = np.maximum(np.abs(bag.rig.top_drive_speed) / REST, load)  # NaN: not known, which is no rest
    held = np.where(busy >= 1.0, 2.0 * largest, hookload + 0.0 * busy)
    for start in np.arange(time[0], time[-1] - wide, 0.5 * wide) if math.isnan(bag.bag.block) else ():
        values = held[slice(*np.searchsorted(time, (start, start + wide)))]
        values = values[np.isfinite(values)]
        steady = values.size >= FEWEST and np.ptp(values) <= HELD * largest
        if steady and SHARES[0] * largest <= np.median(values) <= SHARES[2] * largest:
            found.append((float(np.median(values)), float(start)))
    weight, at = min(found, default=(bag.bag.block, None))
    apart = max(np.diff([start for one, start in found if one <= weight + HELD * largest]), default=0.0)
    known = at is None or weight <= SHARES[1] * largest or apart > APART * wide
    return {"weight_n": weight if known else math.nan, "at_s": at if known else None}


KEYS = ("weight_on_bit_n", "hookload_n", "top_drive_torque_nm", "bit_torque_nm", "drag_n")


def loads(bag: Recording, kept: Mapping[str, Array], block: float = 0.0) -> dict[str, dict[str, float] | None]:
    """Mean from `settled_from` on, least and largest of the whole recording; None for what the bag does not hold.

    Channels of `kept` (`surface.without_spikes`) take the place of the recorded ones; `block` is the weight of the
    block in the hookload [N].

    Keys: `weight_on_bit_n`, `hookload_n`, `top_drive_torque_nm`, `bit_torque_nm` (of the rock on the bit, negative with
    right-handed rotation), as on `/rig/state`, and `drag_n`: hookload plus weight on bit less the weight of the string
    along the hole and the block's, which is the axial friction and inertia; positive = against motion upwards.
    """
    if not len(bag.rig):
        return dict.fromkeys(KEYS)
    rig = bag.rig
    weight = string_weight(bag.scene) if bag.scene_known else np.nan
    names = ("bit_force", "hookload", "top_drive_torque", "bit_torque")
    series, late = [kept.get(name, getattr(rig, name)) for name in names], rig.time >= settled_from(bag)
    drag = series[0] + series[1] - weight - block
    series.append(
        np.where((block > 0.0) & (series[1] - block < 0.5 * weight), np.nan, drag)
    )  # the string hangs in slips
    return {key: _statistics(values, late) for key, values in zip(KEYS, series, strict=True)}


def applied(bag: Recording, kept: Mapping[str, Array], at: Mask | None = None) -> dict[str, dict[str, float] | None]:
    """Statistics of weight on bit [N] and rotation of the top drive [rad/s] at samples, or `settled_from` on."""
    late = bag.rig.time >= settled_from(bag) if at is None else at
    series = (kept.get(name, getattr(bag.rig, name)) for name in ("bit_force", "top_drive_speed"))
    weight, speed = (_statistics(values[late]) for values in series)
    return {"weight_on_bit_n": weight, "rotation_rad_s": speed}


def string_weight(scene: Scene) -> float:
    """Weight of the string along the hole, less buoyancy [N]; 0 without gravity."""
    return float(axial_weight(scene, discretise(scene, build_rod(tubes_of(scene), MOST))).sum())


def _statistics(values: Array, averaged: Mask | bool = True) -> dict[str, float] | None:
    if not (known := values[np.isfinite(values)]).size:
        return None
    late = values[np.isfinite(values) & averaged]
    return {"mean": float((late if late.size else known).mean()), "min": float(known.min()), "max": float(known.max())}


def spectrum_lines(recording: Recording) -> list[dict[str, float]]:
    """Highest lines of the spectrum while the frequency was taken, at its mark: `frequency_hz`, `radius_m`."""
    found, time = recording.summary, recording.marks.time
    if found.whirl_frequency_window_s is None or not found.rotation_rev_s:
        return []
    chosen = slice(*np.searchsorted(time, found.whirl_frequency_window_s))
    mark = [place.name for place in recording.places].index(str(found.frequency_mark))
    lines = lines_of(time[chosen], recording.centre_lines()[chosen, mark], found.rotation_rev_s)
    return [{"frequency_hz": line.frequency, "radius_m": line.radius} for line in lines]


SOFT = 0.1
"""Penetration over the clearance above which the motion depends on the stiffness of the wall."""
FALLEN = 2.0
"""Time at which a string that starts on the axis of an inclined hole has come to rest on the wall [s]."""
FRACTIONS = np.array([0.0, 0.5 - np.sqrt(1.0 / 12.0), 0.5 + np.sqrt(1.0 / 12.0)])
"""Node and Gauss points of an element; the wall acts at the Gauss points."""


def wall_depth(bag: Recording) -> dict[str, Any] | None:
    """Deepest Gauss point of the string in the wall, over the poses from `FALLEN` on; None without a wall or poses.

    Of a string with `numerics.lateral_from`, the Gauss points below its joint count.

    Keys: `deepest_m` (0 without contact), its `distance_from_bit_m` and `time_s`, `clearance_m` there, and `static_m`:
    the depth under the largest weight on bit at rest (`state_judge.static_depth`); None for a record without its file.
    """
    if not bag.scene_known or bag.scene.effects.wall is None or bag.nodes < 2:
        return None
    scene, poses = bag.scene, bag.poses
    curves = along_hole(scene, refined(poses.position, poses.tangent, FRACTIONS))
    up = arc_of(curves[0])
    if not (np.isfinite(curves).all() and up[-1] > 0.0):  # poses that no run of this scene publishes
        return None
    up *= scene.length / up[-1]
    clearance = np.array([scene.clearance_at(float(place)) for place in up])
    depth = np.hypot(curves[..., 0], curves[..., 1]) - clearance
    depth[:, :: FRACTIONS.size] = -np.inf  # nodes, which the wall does not act on
    if (joint := joint_of(scene)) is not None:  # above it the string follows the hole and meets no wall
        first = int(np.argmin(np.abs(up[:: FRACTIONS.size] - joint)))
        depth[:, FRACTIONS.size * first :] = -np.inf
    depth[poses.time < min(FALLEN, poses.time[-1])] = -np.inf
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
    if (block := scene.effects.wall) is None:
        return None
    try:
        load = extremes(scene).weight_on_bit
    except DrillTwinError:  # the record of the rig is not at hand
        return None
    model = discretise(scene, build_rod(tubes_of(scene), MOST))
    bounds = bounds_of(scene, model, wall_parameters(block, model), lateral=False)
    return float(as_python(state_judge.static_depth)(bounds, load))


def soft_wall(found: dict[str, Any] | None, units: UnitSystem) -> Iterator[str]:
    """Yield a note where the string went deep into the wall."""
    if found is None or found["deepest_m"] <= SOFT * found["clearance_m"]:
        return
    depth, share = found["deepest_m"], found["deepest_m"] / found["clearance_m"]
    at_rest = (
        f" (at rest the load presses it in by {units.text(found['static_m'], 'offset')})" if found["static_m"] else ""
    )
    yield (
        f"the wall is soft for this motion: the string went {units.text(depth, 'offset')} into the wall, {share:.0%} "
        f"of the clearance{at_rest}; radii and frequencies depend on the stiffness: compare with a stiffer `wall`"
    )
