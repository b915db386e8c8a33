# SPDX-License-Identifier: Apache-2.0
"""Simulated runs with their measured signals and full state, from which the ground truth is computed."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from drill_twin.core.arrays import Array, ComplexArray
from drill_twin.dynamics.sensors.motion import locate, sub_motion, true_readings
from drill_twin.dynamics.sensors.subs import gravity_of
from drill_twin.dynamics.twin.frame import RigState
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.io.scene_geometry import mark_infos
from drill_twin.runs.ensemble.parts import frames_of, planned
from drill_twin.scene import Scene, parse_scene
from drill_twin.whirl import MarkInfo
from drill_twin_evidence.detection.scene import BENCH_SCENE


@dataclass(frozen=True, eq=False)
class Run:
    """A simulated run; T frames, n + 1 nodes, m marks. Lateral vectors are complex, x + i y."""

    name: str
    """Name of the run."""
    marks: tuple[MarkInfo, ...]
    """The marks, as given to the analyzer."""
    time: Array
    """Times [s], shape (T,)."""
    top_speed: Array
    """Speed of the top drive [rad/s], shape (T,)."""
    point: ComplexArray
    """Marked points as a camera measures them [m], shape (T, m)."""
    mark_spin: Array
    """Spin at the marks [rad], shape (T, m)."""
    mark_force: Array
    """Wall force at the marks [N], shape (T, m)."""
    mark_centre: ComplexArray
    """Centre line at the marks [m], shape (T, m)."""
    arc: Array
    """Distance of the nodes from the bit [m], shape (n + 1,)."""
    centre: ComplexArray
    """Centre line at the nodes [m], shape (T, n + 1)."""
    spin: Array
    """Spin of the nodes [rad], shape (T, n + 1)."""
    clearance: Array
    """Clearance at the nodes [m], shape (n + 1,)."""
    vertical: bool
    """True if the hole is vertical."""
    readings: Array | None = None
    """Readings of perfect sensors at the marks' sections, `SENSOR_RADIUS` from the axis, shape (T, m, 6)."""


TOP_SPEED = RigState._fields.index("top_drive_speed")
SENSOR_RADIUS = 0.006
"""Distance of the sensors of a sub from the axis [m]."""


def simulate(name: str, overrides: Mapping[str, str], *, subs: bool = False, scene_text: str = BENCH_SCENE) -> Run:
    """Run the bench, or another scene, with overrides from start to end and return all signals.

    Args:
        name: Name of the run.
        overrides: Values by key of the scene.
        subs: Whether to read perfect sensors at the sections of the marks too.
        scene_text: The scene.

    Raises:
        SceneError: An override does not fit the scene.
        RunError: A time step did not converge.
    """
    return of_scene(name, parse_scene(scene_text, name=name, overrides=dict(overrides)), subs=subs)


def of_scene(name: str, scene: Scene, *, subs: bool = False) -> Run:
    """Run a scene from start to end and return all signals, as `simulate`."""
    twin = Twin(scene)
    at = np.array([mark.distance_from_bit for mark in scene.string.marks if subs])
    places = locate(twin.rod, at, np.full(at.size, SENSOR_RADIUS), np.zeros(at.size))
    motion, readings = sub_motion(places, *twin.unknowns), list[Array]()
    commands, period = planned(scene)
    columns: list[tuple[Any, ...]] = []
    for frames in frames_of(twin, commands, period):
        marks = frames.marks
        part = (frames.time, frames.rig[:, TOP_SPEED], _lateral(marks.position), marks.spin, marks.wall_force,
                _lateral(marks.centre), _lateral(frames.positions), frames.spin)  # fmt: skip
        columns.append(tuple(column.copy() for column in part))
        if subs and frames.u is not None and frames.v is not None:
            for u, v in zip(frames.u, frames.v, strict=True):
                before, motion = motion, sub_motion(places, u, v)
                readings.append(true_readings(places, before, motion, period, gravity_of(scene)))
    time, speed, point, mark_spin, force, mark_centre, centre, spin = map(np.concatenate, zip(*columns, strict=True))
    arc = np.asarray(twin.rod.arc, float).copy()
    return Run(
        name, tuple(mark_infos(scene)), time, speed, point, mark_spin, force, mark_centre, arc, centre, spin,
        np.array([scene.clearance_at(float(place)) for place in arc]),
        math.isclose(scene.hole.top_inclination, 0.0), np.array(readings) if subs else None,
    )  # fmt: skip


def _lateral(vectors: Array) -> ComplexArray:
    lateral: ComplexArray = vectors[..., 0] + 1j * vectors[..., 1]
    return lateral
