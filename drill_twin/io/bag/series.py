# SPDX-License-Identifier: Apache-2.0
"""Topics as arrays over time: each message adds a row, properties give the columns; T samples, by header stamp."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.errors import ArgumentError, MessageError, nearest
from drill_twin.core.rig_channels import RIG_JOINTS
from drill_twin.dynamics.twin.frame import RigState
from drill_twin.io.bag.time_series import Column, Rows, Series, checked
from drill_twin.io.messages.decode import JointArrays, JointStateReader, JointStates, poses_by_rosbags, read_pose_rows
from drill_twin.io.messages.drawing.transforms import spin_of, tangent_of
from drill_twin.io.messages.rig_messages import read_commands, read_rig_states
from drill_twin.io.messages.whirl_encode import read_whirl_state
from drill_twin.io.samples import RIG_FIELDS, columns, rig_of
from drill_twin.physics.model.section_stress import (
    AXIAL_FORCE,
    CYCLES,
    DAMAGE,
    LARGEST_STRESS,
    MOMENT_X,
    MOMENT_Y,
    SCALARS,
    STRESS,
)

_ALL, _XYZ, _SPIN = slice(None), slice(3), 3


class JointSeries(Series):
    """Series of a topic of JointStates, each of which gives a row."""

    def __init__(self) -> None:
        super().__init__()
        self._reader = JointStateReader()

    def add_message(self, raw: bytes) -> None:
        """Append a message.

        Raises:
            MessageError: The message cannot be decoded, or does not fit the topic.
        """
        self.extend(self._rows(self._reader.read_one(raw)))

    def read(self, raws: Sequence[bytes]) -> Rows | None:
        """Rows of messages, not yet appended; None where their layouts differ.

        Raises:
            MessageError: The first message cannot be decoded, or one does not fit the topic.
        """
        states = self._reader.read_rows(raws)
        return None if states is None else self._rows(states)

    def _rows(self, states: JointStates) -> Rows:
        return checked(Rows(states.stamps, *self._values(states), states=states))

    def _values(self, states: JointStates) -> tuple[Array, tuple[str, ...]]:
        """Values, shape (n, ...), and names of the parts of a row."""
        raise NotImplementedError


class Mark(NamedTuple):
    """A mark over time: the columns of `MarkSeries` for it alone."""

    time: Array
    """[s], shape (T,)."""
    position: Array
    """[m], shape (T, 3)."""
    spin: Array
    """[rad], not wrapped, shape (T,)."""
    velocity: Array
    """[m/s], shape (T, 3)."""
    spin_rate: Array
    """[rad/s], shape (T,)."""
    wall_force: Array
    """[N], shape (T, 3)."""


class MarkSeries(JointSeries):
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
        self._marks: list[tuple[str, ...]] = []
        self._layout: tuple[str, ...] = ()
        self._layout_marks: tuple[str, ...] = ()

    def __getitem__(self, name: str) -> Mark:
        """A mark by its name.

        Raises:
            ArgumentError: There is no such mark.
        """
        if name not in self.names:
            near = nearest(name, self.names) if isinstance(name, str) else ""
            raise ArgumentError(f"expected one of {', '.join(self.names)}, found {name!r}{near}")
        at = self.names.index(name)
        return Mark(self.time, *(getattr(self, column)[:, at] for column in Mark._fields[1:]))

    def _values(self, states: JointStates) -> tuple[Array, tuple[str, ...]]:
        if states.names != self._layout or not states.position.size:
            self._set_layout(states)
        values = np.full((len(states.stamps), 3, len(states.names) + 1), np.nan)
        for k, part in enumerate((states.position, states.velocity, states.effort)):
            values[:, k, : part.shape[1]] = part
        return values[:, :, columns(states.names, self._layout_marks)], self._layout_marks

    def _set_layout(self, state: JointArrays) -> None:
        """Choose the marks of a layout: the marks of an earlier message, if all are there, else all marks."""
        names = state.names
        found = {name.removesuffix("/x"): None for name in names if name.endswith("/x")}
        marks = next((known for known in self._marks if found.keys() >= set(known)), tuple(found))
        if not (marks and state.position.size):
            raise MessageError(f"expected x, y, z and spin of marks, found {', '.join(names) or 'nothing'}")
        columns(names, marks)  # raises where one is not whole
        self._layout, self._layout_marks = names, marks
        if marks not in self._marks:
            self._marks.append(marks)


class RigSeries(JointSeries):
    """`/rig/state`, as in `drill_twin.dynamics.twin.frame.RigState`; each of shape (T,), NaN where another rig has no
    such joint.
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
    drilled = Column(10)
    """[m]"""
    rate_of_penetration = Column(11)
    """[m/s]"""

    def _values(self, states: JointStates) -> tuple[Array, tuple[str, ...]]:
        if states.names == RIG_JOINTS:
            return read_rig_states(states), ()
        values = np.full((len(states.stamps), len(RigState._fields)), np.nan)
        values[:, RIG_FIELDS[:2]] = rig_of(states)[:, :2]
        return values, ()


class CommandSeries(JointSeries):
    """`/rig/command`."""

    weight_on_bit = Column(0)
    """Weight on bit [N], NaN where a command has none, shape (T,)."""
    rotation = Column(1)
    """Top-drive speed [rad/s], NaN where a command has none, shape (T,)."""

    def _values(self, states: JointStates) -> tuple[Array, tuple[str, ...]]:
        return read_commands(states)[:, :2], ()


class StressSeries(JointSeries):
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

    def _values(self, states: JointStates) -> tuple[Array, tuple[str, ...]]:
        names = tuple(dict.fromkeys(name.partition("/")[0] for name in states.names))
        if not names or states.names != tuple(f"{name}/{scalar}" for name in names for scalar in SCALARS):
            raise MessageError(
                f"expected <section>/{', /'.join(SCALARS)}, found {', '.join(states.names) or 'nothing'}"
            )
        return states.position.reshape(-1, len(names), len(SCALARS)), names


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
        """Append a message if it is the first of each `every`; the others are not kept.

        Raises:
            MessageError: The message cannot be decoded, or has a number that is not finite.
        """
        try:
            self.extend(self._rows(*(read_pose_rows([raw]) or poses_by_rosbags(raw))))
        except MessageError:
            self.seen += 1
            raise

    def read(self, raws: Sequence[bytes]) -> Rows | None:
        """As of `JointSeries`."""
        found = read_pose_rows(raws)
        return None if found is None else self._rows(*found)

    def _rows(self, stamps: list[int], poses: Array) -> Rows:
        if not np.isfinite(poses).all():
            raise MessageError("expected poses of the nodes, found a number that is not finite")
        kept = [(self.seen + k) % self._every == 0 for k in range(len(stamps))]  # `extend` counts them
        return checked(Rows(stamps, poses, kept=kept))

    def extend(self, found: Rows) -> None:
        """As of `Series`."""
        self.seen += len(found.stamps)
        super().extend(found)

    @property
    def tangent(self) -> Array:
        """Unit tangents, shape (T, n + 1, 3)."""
        return tangent_of(self.orientation)

    @property
    def spin(self) -> Array:
        """Spins [rad], unwrapped over time, shape (T, n + 1)."""
        return np.unwrap(spin_of(self.orientation), axis=0, period=4.0 * np.pi)


class WhirlSeries(JointSeries):
    """`/whirl/state`; m marks."""

    orbit_radius = Column(0)
    """Radius of the centre line's orbit [m], shape (T, m)."""
    precession_rad_s = Column(1)
    """Precession [rad/s], positive = forward, shape (T, m)."""
    ratio = Column(2)
    """Whirl ratio, shape (T, m)."""
    confidence = Column(3)
    """Confidence, 0 to 1, shape (T, m)."""
    motion = Column(4)
    """Codes of the motion states (`drill_twin.whirl.MotionCode`), shape (T, m)."""

    def _values(self, states: JointStates) -> tuple[Array, tuple[str, ...]]:
        marks, values = read_whirl_state(states)
        return values.swapaxes(1, 2), marks

    @property
    def precession(self) -> Array:
        """Precession [rev/s], positive = forward, shape (T, m)."""
        return self.precession_rad_s / math.tau
