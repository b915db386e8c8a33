# SPDX-License-Identifier: Apache-2.0
"""Severity of a run: extremes, contact, and the extremes of its last half."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from drill_twin.dynamics.discretisation.discretise import tubes_of
from drill_twin.dynamics.twin.bending_stress import bending_stress
from drill_twin.dynamics.twin.frame_record import FrameSeries, RigSeries
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.runs.ensemble.outputs.collector import Collector, Request, Variable


class Extremes(Collector):
    """Largest and smallest values of the run."""

    def __init__(self, twin: Twin, request: Request) -> None:
        super().__init__(twin, request)
        self._largest: dict[str, Any] = {}
        self._smallest: dict[str, Any] = {}

    def add(self, rows: FrameSeries, rig: RigSeries) -> None:
        """Compare with the extremes so far."""
        largest = {
            "radius": np.hypot(rows.centre[..., 0], rows.centre[..., 1]),
            "wall_force": rows.wall_force,
            "string_wall_force": rows.string[:, 0],
            "penetration": rows.string[:, 1],
        }
        both = {"torque": rig.top_drive_torque, "bit_torque": rig.bit_torque, "hookload": rig.hookload,
                "bit_speed": rig.bit_speed}  # fmt: skip
        for name, values in (largest | both).items():
            self._largest[name] = np.maximum(self._largest.get(name, -np.inf), values.max(axis=0))
        for name, values in both.items():
            self._smallest[name] = np.minimum(self._smallest.get(name, np.inf), values.min(axis=0))

    def close(self) -> Mapping[str, Variable]:
        """Extremes by name."""
        units = {"radius": "m", "penetration": "m", "torque": "N m", "bit_torque": "N m", "bit_speed": "rad/s"}
        of_marks = {"radius", "wall_force"}

        def variables(found: Mapping[str, Any], suffix: str) -> dict[str, Variable]:
            return {
                f"{name}_{suffix}": Variable(value, ("mark",) if name in of_marks else (), units.get(name, "N"))
                for name, value in found.items()
            }

        return {**variables(self._largest, "max"), **variables(self._smallest, "min")}


class LastHalf(Collector):
    """Severity of the motion once it has settled: extremes of the last half of the run."""

    def __init__(self, twin: Twin, request: Request) -> None:
        super().__init__(twin, request)
        self._frames = 0
        self._radius: Any = 0.0
        self._force = 0.0
        self._torque = (math.inf, -math.inf)

    def add(self, rows: FrameSeries, rig: RigSeries) -> None:
        """Compare the frames after the middle of the run."""
        first = max(0, self.request.frames // 2 - self._frames)
        self._frames += rows.time.size
        if first < rows.time.size:
            self._radius = np.maximum(
                self._radius, np.hypot(rows.centre[first:, :, 0], rows.centre[first:, :, 1]).max(0)
            )
            self._force = max(self._force, float(rows.string[first:, 0].max()))
            torque, (low, high) = rig.top_drive_torque[first:], self._torque
            self._torque = min(low, float(torque.min())), max(high, float(torque.max()))

    def close(self) -> Mapping[str, Variable]:
        """Radius of the marks, wall force, swing of the torque; bending stress at the last instant."""
        low, high = self._torque
        dynamics = self.twin.dynamics
        stress = bending_stress(dynamics.rod, tubes_of(self.twin.scene), dynamics.unknowns[0])
        radius = np.broadcast_to(self._radius, (len(self.twin.scene.string.marks),)).copy()
        return {
            "radius_late": Variable(radius, ("mark",), "m"),
            "wall_force_late": Variable(self._force, (), "N"),
            "torque_swing_late": Variable(high - low if high >= low else math.nan, (), "N m"),
            "bending_stress_end": Variable(float(stress.max()), (), "Pa"),
        }


class Contact(Collector):
    """Share of the frames with contact at each mark, and mean share of the nodes in contact."""

    _touching: Any = 0
    _nodes = 0.0
    _frames = 0

    def add(self, rows: FrameSeries, rig: RigSeries) -> None:
        """Count frames with contact."""
        del rig
        self._touching = self._touching + (rows.wall_force > 0.0).sum(axis=0)
        self._nodes += float(rows.string[:, 2].sum())
        self._frames += rows.time.size

    def close(self) -> Mapping[str, Variable]:
        """Shares."""
        return {
            "contact_share": Variable(self._touching / self._frames, ("mark",), "1"),
            "string_contact_share": Variable(self._nodes / self._frames, (), "1"),
        }
