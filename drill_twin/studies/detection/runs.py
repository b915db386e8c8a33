# SPDX-License-Identifier: Apache-2.0
"""Simulated runs with their measured signals and full state, from which the ground truth is computed."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from drill_twin.base.arrays import Array, ComplexArray
from drill_twin.ensemble.outputs import Collector, Request, Variable
from drill_twin.ensemble.run import frames_of, run_scene
from drill_twin.errors import RunError
from drill_twin.io.scene_geometry import mark_infos
from drill_twin.scene import parse_scene
from drill_twin.sensors.motion import locate, sub_motion, true_readings
from drill_twin.sensors.subs import gravity_of
from drill_twin.studies.detection.scene import BENCH_SCENE
from drill_twin.twin.frame import Frames, RigState
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
    scene = parse_scene(scene_text, name=name, overrides=dict(overrides))
    member = run_scene(scene, [partial(_Signals, subs=subs)], *frames_of(scene))
    if member.failure:
        raise RunError(member.failure)
    run: Run = member.values["run"].value
    return replace(run, name=name)


class _Signals(Collector):
    """All signals of a run."""

    whole = True

    def __init__(self, twin: Twin, request: Request, *, subs: bool) -> None:
        super().__init__(twin, request)
        at = np.array([mark.distance_from_bit for mark in twin.scene.string.marks if subs])
        self._places = locate(twin.rod, at, np.full(at.size, SENSOR_RADIUS), np.zeros(at.size))
        self._motion = sub_motion(self._places, *twin.unknowns) if subs else None
        self._parts: list[tuple[Array | ComplexArray, ...]] = []

    def add_frames(self, frames: Frames) -> None:
        """Add frames."""
        marks, speed = frames.marks, frames.rig[:, RigState._fields.index("top_drive_speed")]
        part = (
            frames.time, speed, _lateral(marks.position), marks.spin, marks.wall_force, _lateral(marks.centre),
            _lateral(frames.positions), frames.spin, np.array(list(self._readings(frames))),
        )  # fmt: skip
        self._parts.append(tuple(array.copy() for array in part))

    def _readings(self, frames: Frames) -> Iterator[Array]:
        if self._motion is None or frames.u is None or frames.v is None:
            return
        for u, v in zip(frames.u, frames.v, strict=True):
            before, self._motion = self._motion, sub_motion(self._places, u, v)
            yield true_readings(self._places, before, self._motion, self.request.period, gravity_of(self.twin.scene))

    def close(self) -> Mapping[str, Variable]:
        """The run."""
        scene, arc = self.twin.scene, np.asarray(self.twin.rod.arc, float).copy()
        columns: Any = (np.concatenate(parts) for parts in zip(*self._parts, strict=True))
        time, speed, point, mark_spin, force, mark_centre, centre, spin, readings = columns
        run = Run(
            scene.name, tuple(mark_infos(scene)), time, speed, point, mark_spin, force, mark_centre, arc, centre, spin,
            np.array([scene.clearance_at(float(place)) for place in arc]),
            math.isclose(scene.hole.top_inclination, 0.0), None if self._motion is None else readings,
        )  # fmt: skip
        return {"run": Variable(run, (), "")}


def _lateral(vectors: Array) -> ComplexArray:
    lateral: ComplexArray = vectors[..., 0] + 1j * vectors[..., 1]
    return lateral
