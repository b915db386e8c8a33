# SPDX-License-Identifier: Apache-2.0
"""Outputs of a run as a whole: extremes, contact, the last half, motion still changing at the end, fatigue, energy.

The lateral motion of a mark in each of the last two quarters is z = a + b exp(i psi) + r, with a in space, b in the
string (bow, imbalance, a buckled shape) and psi its spin; a and b by least squares. A whirl begins
as the rest r, so the size of r in the two quarters tells whether a whirl grows long before it reaches the wall.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.errors import ArgumentError
from drill_twin.dynamics.twin.frame_record import FrameSeries, RigSeries
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.io.messages.stamps import NANOSECONDS, seconds
from drill_twin.physics.model.section_stress import CYCLES, DAMAGE, LARGEST_STRESS, bending_stress
from drill_twin.scene import Scene
from drill_twin.scene.set_points import Command, Schedule
from drill_twin.whirl.motion.stick_slip_index import TIME_BASE, stick_slip_index


@dataclass(frozen=True)
class Request:
    """Outputs asked for, the same for all members.

    Attributes:
        names: Names of the outputs, of `OUTPUTS`.
        period: Length of a frame [s].
        frames: Frames of a run.
        every: Frames from one sample of the marks to the next.
        played: Times [s] and values [SI] of set-points in place of the scene's, by name of a `Command`'s field; linear
            between, held before and after.
    """

    names: tuple[str, ...]
    period: float
    frames: int
    every: int
    played: Mapping[str, tuple[Array, Array]] = field(default_factory=dict)

    def commands(self, scene: Scene) -> Array:
        """Set-points of a run of a scene at the ends of its frames, as a `Command`, shape (frames, 3)."""
        period = round(self.period * NANOSECONDS)
        ends = [seconds(frame * period) for frame in range(1, self.frames + 1)]
        found = Schedule.from_scene(scene).over(ends)
        for name, (time, values) in self.played.items():
            found[:, Command._fields.index(name)] = np.interp(ends, time, values)
        return found


class Variable(NamedTuple):
    """Value of one member."""

    value: Any
    dimensions: tuple[str, ...]
    unit: str


class Collector:
    """Gathers one output of a member."""

    def __init__(self, twin: Twin, request: Request) -> None:
        """Begin with the first frame."""
        self.twin, self.request = twin, request
        self.begin()

    def begin(self) -> None:
        """Prepare for the first frame."""

    def add(self, rows: FrameSeries, rig: RigSeries) -> None:
        """Add the next frames."""

    def close(self) -> Mapping[str, Variable]:
        """Values of the whole run, by name."""
        raise NotImplementedError


class Extremes(Collector):
    """Largest and smallest values of the run."""

    def begin(self) -> None:
        """Prepare for the first frame."""
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

    def begin(self) -> None:
        """Prepare for the first frame."""
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
        stress = bending_stress(dynamics.rod, dynamics.unknowns[0])
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

    def add(self, rows: FrameSeries, _rig: RigSeries) -> None:
        """Count frames with contact."""
        self._touching = self._touching + (rows.wall_force > 0.0).sum(axis=0)
        self._nodes += float(rows.string[:, 2].sum())
        self._frames += rows.time.size

    def close(self) -> Mapping[str, Variable]:
        """Shares."""
        return {
            "contact_share": Variable(self._touching / self._frames, ("mark",), "1"),
            "string_contact_share": Variable(self._nodes / self._frames, (), "1"),
        }


class Fatigue(Collector):
    """Stress and damage of the sections of scenes with the effect `fatigue`."""

    def close(self) -> Mapping[str, Variable]:
        """Largest stress, cycles and damage of the whole run."""
        found = self.twin.dynamics.stress
        if found is None:
            raise ArgumentError("outputs: expected a scene with effects.fatigue for `fatigue`, found none")
        columns = (("largest_stress", LARGEST_STRESS, "Pa"), ("stress_cycles", CYCLES, "1"), ("damage", DAMAGE, "1"))
        return {name: Variable(found[:, column].copy(), ("section",), unit) for name, column, unit in columns}


class Energy(Collector):
    """Energy balance at the end, of scenes with `numerics.audit: energy`."""

    def close(self) -> Mapping[str, Variable]:
        """Dissipation by effect, work, and the residual."""
        found = self.twin.energy()
        if found is None:
            raise ArgumentError("outputs: expected a scene with numerics.audit: energy for `energy`, found none")
        energies = {"dissipated": found.dissipated, "work": found.work, "stored": found.stored}
        variables = {
            f"energy_{kind}_{name}": Variable(value, (), "J")
            for kind, parts in energies.items()
            for name, value in parts.items()
        }
        return {**variables, "energy_residual": Variable(found.share, (), "1")}


ROUND_OFF = 1e-8
"""Least rest of the motion that is more than round-off, over the motion itself."""


class Settling(Collector):
    """Rest of the motion and lateral acceleration in the last two quarters, stick-slip index in the last time bases."""

    def begin(self) -> None:
        """Prepare for the first frame."""
        self._quarter = self.request.frames // 4
        marks = len(self.twin.scene.string.marks)
        self._gram = np.zeros((2, marks, 3, 3), complex)  # of 1, exp(i psi) and z
        self._before = np.full((2, marks), np.nan, complex)  # z of the last two frames
        self._squares, self._peak = np.zeros((2, marks)), np.full(marks, np.nan)  # of the second difference of z
        self._base = max(1, min(self._quarter, math.ceil(TIME_BASE / self.request.period)))
        self._speed = np.empty((2, 0))  # of bit and top drive
        self._frames = 0

    def add(self, rows: FrameSeries, rig: RigSeries) -> None:
        """Add the frames of the last half."""
        speed = np.hstack((self._speed, np.array([rig.bit_speed, rig.top_drive_speed])))
        self._speed = speed[:, -2 * self._base :]
        line = np.concatenate((self._before, rows.centre[..., 0] + 1j * rows.centre[..., 1]))
        bent, self._before = np.abs(np.diff(line, 2, axis=0)), line[-2:]
        for k in range(2):
            first = self.request.frames - (2 - k) * self._quarter - self._frames
            part = slice(max(0, first), max(0, first + self._quarter))
            spin = rows.spin[part]
            if spin.size:
                terms = np.array([np.ones_like(spin), np.exp(1j * spin), line[2:][part]])
                self._gram[k] += np.einsum("afm,bfm->mab", terms.conj(), terms)
                self._squares[k] += (bent[part] ** 2).sum(axis=0)
                self._peak = np.fmax(self._peak, bent[part].max(axis=0))
        self._frames += rows.time.size

    def close(self) -> Mapping[str, Variable]:
        """Radius of the rest of each mark, its acceleration by second differences as in the report; stick-slip index
        and mean speed of bit and top drive.
        """
        rest = np.array([[_rest(gram) for gram in quarter] for quarter in self._gram])
        parts = np.split(self._speed, [max(0, self._speed.shape[1] - self._base)], axis=1)
        square = self.request.period**2
        index = np.array([[stick_slip_index(place) if place.size else math.nan for place in part] for part in parts])
        return {
            "lateral_rest": Variable(rest.reshape(2, -1), ("quarter", "mark"), "m"),
            "lateral_rms": Variable(
                np.sqrt(self._squares / max(self._quarter, 1)) / square, ("quarter", "mark"), "m/s^2"
            ),
            "lateral_peak": Variable(self._peak / square, ("mark",), "m/s^2"),
            "stick_slip_index": Variable(index, ("time_base", "place"), "1"),
            "mean_speed": Variable(parts[1].mean(axis=1), ("place",), "rad/s"),
        }


def _rest(gram: Array) -> float:
    """Root mean square of what 1 and exp(i psi) do not explain of z, from the products of the three, shape (3, 3)."""
    samples, whole = gram[0, 0].real, gram[2, 2].real
    if not samples:
        return math.nan
    explained = np.vdot(gram[:2, 2], np.linalg.lstsq(gram[:2, :2], gram[:2, 2], rcond=1e-12)[0]).real
    return math.sqrt(max(whole - explained, ROUND_OFF**2 * whole, 0.0) / samples)
