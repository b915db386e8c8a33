# SPDX-License-Identifier: Apache-2.0
"""Topics as arrays over time: each message adds a row, properties give the columns; T samples, by header stamp."""

from __future__ import annotations

import math

import numpy as np

from drill_twin.base.arrays import Array
from drill_twin.errors import MessageError
from drill_twin.io.bag.time_series import Column, Series
from drill_twin.io.messages.decode import JointStateReader, read_pose_array
from drill_twin.io.messages.encode import MARK_AXES
from drill_twin.io.messages.pose import spin_of, tangent_of
from drill_twin.io.messages.rig_messages import RIG_JOINTS, read_command, read_rig_state
from drill_twin.io.messages.whirl_encode import read_whirl_state
from drill_twin.io.samples import columns, speeds
from drill_twin.model.section_stress import (
    AXIAL_FORCE,
    CYCLES,
    DAMAGE,
    LARGEST_STRESS,
    MOMENT_X,
    MOMENT_Y,
    SCALARS,
    STRESS,
)
from drill_twin.twin.frame import RigState

_ALL, _XYZ, _SPIN = slice(None), slice(3), 3
_UNKNOWN_RIG = RigState(*[math.nan] * len(RigState._fields))


class MarkSeries(Series):
    """`/marks/state`; m marks. NaN where the messages have no z, spin, velocity or force."""

    position = Column(0, _ALL, _XYZ)
    """Positions [m], shape (T, m, 3)."""
    spin = Column(0, _ALL, _SPIN)
    """Spins [rad], not wrapped, shape (T, m)."""
    velocity = Column(1, _ALL, _XYZ)
    """Velocities [m/s], shape (T, m, 3)."""
    spin_rate = Column(1, _ALL, _SPIN)
    """Spin rates [rad/s], shape (T, m)."""
    wall_force = Column(2, _ALL, _XYZ)
    """Forces of the wall on the string [N], shape (T, m, 3)."""

    def __init__(self) -> None:
        super().__init__()
        self._reader = JointStateReader()
        self._marks: list[tuple[str, ...]] = []
        self._layout: tuple[str, ...] = ()
        self._layout_marks: tuple[str, ...] = ()
        self._columns = np.zeros((0, len(MARK_AXES)), np.intp)

    def add_message(self, raw: bytes) -> None:
        """Append a message.

        Raises:
            MessageError: It cannot be decoded, has no positions, or an x without a y.
        """
        state = self._reader.read(raw)
        if not state.position.size:
            raise MessageError(f"expected x, y, z and spin of marks, found {', '.join(state.names) or 'nothing'}")
        if state.names != self._layout:
            self._set_layout(state.names)
        missing = np.full(len(state.names), np.nan)
        parts = (part if part.size else missing for part in (state.position, state.velocity, state.effort))
        self.append(state.stamp, [np.append(part, np.nan)[self._columns] for part in parts], self._layout_marks)

    def _set_layout(self, names: tuple[str, ...]) -> None:
        """Find the columns of these joints: of the marks of an earlier message, if all are there, else of all marks."""
        found = {name.removesuffix("/x"): None for name in names if name.endswith("/x")}
        marks = next((known for known in self._marks if found.keys() >= set(known)), tuple(found))
        if not marks:
            raise MessageError(f"expected x, y, z and spin of marks, found {', '.join(names) or 'nothing'}")
        self._columns = columns(names, marks)
        self._layout, self._layout_marks = names, marks
        if marks not in self._marks:
            self._marks.append(marks)


class RigSeries(Series):
    """`/rig/state`, as in `drill_twin.twin.frame.RigState`; each of shape (T,), NaN where another rig has no such
    joint.
    """

    top_drive_angle = Column(0)
    """[rad]"""
    top_drive_speed = Column(1)
    """[rad/s]"""
    top_drive_torque = Column(2)
    """[N m]"""
    bit_angle = Column(3)
    """[rad]"""
    bit_speed = Column(4)
    """[rad/s]"""
    bit_torque = Column(5)
    """[N m]"""
    bit_force = Column(6)
    """Weight on bit [N]."""
    block_position = Column(7)
    """[m]"""
    block_velocity = Column(8)
    """[m/s]"""
    hookload = Column(9)
    """[N]"""

    def __init__(self) -> None:
        super().__init__()
        self._reader = JointStateReader()

    def add_message(self, raw: bytes) -> None:
        """Append a message.

        Raises:
            MessageError: It cannot be decoded, or has no speed of the top drive.
        """
        state = self._reader.read(raw)
        if state.names == RIG_JOINTS:
            rig = read_rig_state(state)
        else:
            top_drive, bit = speeds(state)
            rig = _UNKNOWN_RIG._replace(top_drive_speed=top_drive, bit_speed=bit)
        self.append(state.stamp, rig)


class CommandSeries(Series):
    """`/rig/command`."""

    weight_on_bit = Column(0)
    """Weight on bit [N], shape (T,)."""
    rotation = Column(1)
    """Top-drive speed [rad/s], shape (T,)."""

    def __init__(self) -> None:
        super().__init__()
        self._reader = JointStateReader()

    def add_message(self, raw: bytes) -> None:
        """Append a message.

        Raises:
            MessageError: It cannot be decoded, or lacks a set-point.
        """
        state = self._reader.read(raw)
        command = read_command(state)
        self.append(state.stamp, (command.weight_on_bit, command.rotation))


class StressSeries(Series):
    """`/string/stress`; s sections."""

    moment_x = Column(_ALL, MOMENT_X)
    """Bending moment that curves the string towards x of the turning material [N m], shape (T, s)."""
    moment_y = Column(_ALL, MOMENT_Y)
    """The same towards y [N m], shape (T, s)."""
    axial_force = Column(_ALL, AXIAL_FORCE)
    """Axial force, positive = tension [N], shape (T, s)."""
    stress = Column(_ALL, STRESS)
    """Largest normal stress at the surface at the instant [Pa], shape (T, s)."""
    largest_stress = Column(_ALL, LARGEST_STRESS)
    """Largest of all steps so far [Pa], shape (T, s)."""
    cycles = Column(_ALL, CYCLES)
    """Stress cycles so far of the fibre with the most damage, shape (T, s)."""
    damage = Column(_ALL, DAMAGE)
    """Its damage so far, shape (T, s)."""

    def __init__(self) -> None:
        super().__init__()
        self._reader = JointStateReader()

    def add_message(self, raw: bytes) -> None:
        """Append a message.

        Raises:
            MessageError: It cannot be decoded, or is not one of sections.
        """
        state = self._reader.read(raw)
        names = tuple(dict.fromkeys(name.partition("/")[0] for name in state.names))
        if not names or state.names != tuple(f"{name}/{scalar}" for name in names for scalar in SCALARS):
            raise MessageError(f"expected <section>/{', /'.join(SCALARS)}, found {', '.join(state.names) or 'nothing'}")
        self.append(state.stamp, state.position.reshape(len(names), len(SCALARS)), names)


class PoseSeries(Series):
    """`/string/poses`; n + 1 nodes, 0 = bit."""

    position = Column(_ALL, _XYZ)
    """Positions [m], shape (T, n + 1, 3)."""
    orientation = Column(_ALL, slice(3, 7))
    """Unit quaternions x y z w, shape (T, n + 1, 4)."""

    def __init__(self, every: int = 1) -> None:
        super().__init__()
        self._every, self.seen = every, 0

    def add_message(self, raw: bytes) -> None:
        """Append a message, if it is one of those that are kept: the first of each `every`.

        Raises:
            MessageError: It cannot be decoded, or has a number that is not finite.
        """
        keep = self.seen % self._every == 0
        self.seen += 1
        poses = read_pose_array(raw)
        row = np.concatenate((poses.position, poses.orientation), axis=1)
        if not np.isfinite(row).all():
            raise MessageError("expected poses of the nodes, found a number that is not finite")
        self.append(poses.stamp, row, keep=keep)

    @property
    def tangent(self) -> Array:
        """Unit tangents, shape (T, n + 1, 3)."""
        return tangent_of(self.orientation)

    @property
    def spin(self) -> Array:
        """Spins [rad], unwrapped over time, shape (T, n + 1)."""
        return np.unwrap(spin_of(self.orientation), axis=0, period=4.0 * np.pi)


class WhirlSeries(Series):
    """`/whirl/state`; m marks."""

    orbit_radius = Column(0)
    """Radius of the centre line's orbit [m], shape (T, m)."""
    precession = Column(1)
    """Precession [rev/s], positive = forward, shape (T, m)."""
    ratio = Column(2)
    """Precession over rotation, shape (T, m)."""
    confidence = Column(3)
    """Confidence, 0 to 1, shape (T, m)."""

    def __init__(self) -> None:
        super().__init__()
        self._reader = JointStateReader()

    def add_message(self, raw: bytes) -> None:
        """Append a message.

        Raises:
            MessageError: It cannot be decoded, or is not one of findings.
        """
        state = read_whirl_state(self._reader.read(raw))
        self.append(
            state.stamp, (state.orbit_radius, state.precession, state.ratio, state.confidence), names=state.marks
        )
