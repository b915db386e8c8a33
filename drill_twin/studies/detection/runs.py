# SPDX-License-Identifier: Apache-2.0
"""Simulated runs with their measured signals and full state, from which the ground truth is computed."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from drill_twin.base.arrays import Array, ComplexArray
from drill_twin.io.scene_geometry import mark_infos
from drill_twin.scene import parse_scene
from drill_twin.schedule import Schedule
from drill_twin.sensors.motion import locate, sub_motion, true_readings
from drill_twin.sensors.subs import gravity_of
from drill_twin.studies.detection.scene import BENCH_SCENE
from drill_twin.twin.frame import Frame
from drill_twin.twin.twin import Twin
from drill_twin.whirl import MarkInfo


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


SENSOR_RADIUS = 0.006
"""Distance of the sensors of a sub from the axis [m]."""


def simulate(name: str, overrides: Mapping[str, str], *, subs: bool = False) -> Run:
    """Run the bench with overrides from start to end and return all signals, those of `subs` where asked for.

    Raises:
        SceneError: An override does not fit the scene.
        RunError: A time step did not converge.
    """
    scene = parse_scene(BENCH_SCENE, name=name, overrides=dict(overrides))
    schedule, twin = Schedule.from_scene(scene), Twin(scene)
    period = 1.0 / scene.numerics.frame_rate
    count = round(schedule.duration / period)
    at = np.array([mark.distance_from_bit for mark in scene.string.marks if subs])
    places = locate(twin.rod, at, np.full(at.size, SENSOR_RADIUS), np.zeros(at.size))
    motion, readings, frames = sub_motion(places, *twin.unknowns), [], []
    for i in range(count):
        frames.append(twin.advance(schedule.at((i + 1) * period), period))
        if subs:
            before, motion = motion, sub_motion(places, *twin.unknowns)
            readings.append(true_readings(places, before, motion, period, gravity_of(scene)))
    time = np.array([frame.time for frame in frames])
    return Run(
        name,
        tuple(mark_infos(scene)),
        time,
        np.array([frame.rig.top_drive_speed for frame in frames]),
        _lateral(frames, "position", of_marks=True),
        np.array([frame.marks.spin for frame in frames]),
        np.array([frame.marks.wall_force for frame in frames]),
        _lateral(frames, "centre", of_marks=True),
        np.asarray(twin.rod.arc, float).copy(),
        _lateral(frames, "positions"),
        np.array([frame.spin for frame in frames]),
        np.array([scene.clearance_at(float(arc)) for arc in twin.rod.arc]),
        math.isclose(scene.hole.top_inclination, 0.0),
        np.array(readings) if subs else None,
    )


def _lateral(frames: list[Frame], field: str, *, of_marks: bool = False) -> ComplexArray:
    vectors = np.array([getattr(frame.marks if of_marks else frame, field) for frame in frames])
    lateral: ComplexArray = vectors[..., 0] + 1j * vectors[..., 1]
    return lateral
