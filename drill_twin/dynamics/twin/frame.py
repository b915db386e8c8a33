# SPDX-License-Identifier: Apache-2.0
"""Frame: published state of string, marks and rig at one instant.

Nodes are numbered from the bit (0) to the top clamp (n). Vectors are in the frame `hole`: origin at the top clamp, z up
along the hole's axis there, x to the low side. In a curved hole, marks are in the frame of the hole at their depth: x
and y from its axis, z along it (minus the measured depth); in a straight hole both are the same. All values are SI and
float64; the arrays of a frame are views of one row of memory, which holds as long as they do.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from drill_twin.core.arrays import Array


class MarkStates(NamedTuple):
    """State of the marks, in the order of the scene; m marks."""

    position: Array
    """Positions of the marked points [m], shape (m, 3); a point on the surface of the string rotates with the spin."""
    velocity: Array
    """Velocities of the marked points [m/s], shape (m, 3)."""
    spin: Array
    """Spin of the section at the mark [rad], shape (m,), not wrapped."""
    spin_rate: Array
    """Spin rate [rad/s], shape (m,)."""
    wall_force: Array
    """Normal force of the wall on the string at the mark [N], shape (m,), not negative."""
    centre: Array
    """Positions of the centre line at the marks [m], shape (m, 3)."""


class RigState(NamedTuple):
    """State of the rig and of the bit, as applied."""

    top_drive_angle: float
    """Angle of the top drive [rad], not wrapped."""
    top_drive_speed: float
    """Speed of the top drive [rad/s]."""
    top_drive_torque: float
    """Torque of the top drive on the string [N m]."""
    bit_angle: float
    """Spin of the bit [rad], not wrapped."""
    bit_speed: float
    """Spin rate of the bit [rad/s]."""
    bit_torque: float
    """Torque of the rock on the bit [N m]."""
    bit_force: float
    """Weight on bit as applied [N], positive = compression."""
    block_position: float
    """Height of the travelling block above its start [m]."""
    block_velocity: float
    """Velocity of the travelling block [m/s], positive up."""
    hookload: float
    """Upward force on the string at the top [N]."""
    drilled: float
    """Depth drilled since the start [m]; 0 without a bit that cuts."""
    rate_of_penetration: float
    """Its mean rate over the frame [m/s]."""


class StepStats(NamedTuple):
    """Numerical effort of a frame."""

    steps: int
    """Time steps taken."""
    iterations: int
    """Newton iterations in all steps."""
    cut_steps: int
    """Steps that were halved."""
    steps_above_tolerance: int
    """Steps accepted at ten times the tolerance, as points on the wall alternated between stick and slip."""
    wall_seconds: float
    """Wall-clock time of the computation [s]."""


COUNTS = ("steps", "cut_steps", "steps_above_tolerance")
"""Fields of `StepStats` in diagnostics and summary."""


@dataclass(frozen=True)
class Intervention:
    """Frame that the step guard rejected and repeated with a smaller step."""

    time: float
    """Simulated time of the last good frame before it [s]."""
    kind: str
    """Kind of the violation: finite, newton, speed, strain, fold, slope, penetration or energy."""
    node: int
    """Node at which it was largest."""
    distance_from_bit: float
    """Its distance from the bit [m]."""
    text: str
    """Description for messages."""
    tries: int
    """Number of retries."""
    step: float
    """Time step of the last retry, which succeeded [s]."""


@dataclass(frozen=True)
class EnergyBalance:
    """Energy balance of the string since the start of the run [J]."""

    stored: Mapping[str, float]
    """Stored energy: kinetic, bending, stretch, torsion, gravity (since the start) and wall."""
    work: Mapping[str, float]
    """Work on the string: weight_on_bit, top_drive, top_clamp, and by effect, including the elastic energy of the wall;
    dissipation is negative work."""
    dissipated: Mapping[str, float]
    """Dissipated energy, by effect."""
    residual: float
    """Error of the balance: gained if positive."""
    scale: float
    """Largest converted energy so far, the reference of the residual: kinetic, change of the others, dissipation."""
    newton: float
    """Part of the residual due to the tolerance of Newton's method."""

    @property
    def share(self) -> float:
        """Residual over scale."""
        return self.residual / self.scale


class Frame(NamedTuple):
    """The string at one instant; n elements, n + 1 nodes."""

    time: float
    """Simulated time [s]."""
    positions: Array
    """Node positions [m], shape (n + 1, 3)."""
    velocities: Array
    """Node velocities [m/s], shape (n + 1, 3)."""
    tangents: Array
    """Unit tangents, pointing from the bit to the top, shape (n + 1, 3)."""
    spin: Array
    """Spin of the sections about the tangent [rad], shape (n + 1,), not wrapped."""
    spin_rate: Array
    """Spin rate [rad/s], shape (n + 1,)."""
    wall_force: Array
    """Normal wall force at the nodes [N], shape (n + 1,), not negative."""
    wall_depth: float
    """Largest penetration of the string's surface into the wall at the Gauss points [m], also without the effect
    `wall`; negative without contact."""
    wall_depth_at: float
    """Distance of that point from the bit [m]."""
    marks: MarkStates
    """Marks."""
    rig: RigState
    """Rig."""
    stats: StepStats
    """Numerical effort."""
    intervention: Intervention | None = None
    """Record of the step guard if the frame was repeated."""
    energy: EnergyBalance | None = None
    """Energy balance if the scene asks for an audit."""
    stress: Array | None = None
    """Sections with the effect `fatigue`, in the order of the scene: columns of `SCALARS`
    (`drill_twin.physics.model.section_stress`), shape (s, 7)."""


class Frames(NamedTuple):
    """F frames one after the other: the fields of `Frame`, with F as the first axis of each array."""

    time: Array
    """Simulated times [s], shape (F,)."""
    positions: Array
    tangents: Array
    spin: Array
    wall_force: Array
    wall_depth: Array
    wall_depth_at: Array
    marks: MarkStates
    rig: Array
    """Fields of `RigState`, shape (F, 12)."""
    stats: StepStats
    """Numerical effort of all frames."""
    interventions: Sequence[Intervention]
    """Records of the step guard, in order."""
    energy: EnergyBalance | None
    """Energy balance at the end of the last frame."""
    stress: Array | None
    u: Array | None = None
    """Node rows (r, r', psi), shape (F, n + 1, 7), for the sensors of a scene."""
    v: Array | None = None
    """Their velocities."""

    def part(self, rows: slice | Sequence[int]) -> Frames:
        """Select some of the frames; numerical effort and interventions stay the sums over all frames."""
        fields: dict[str, Any] = self._asdict()
        arrays = {name: value[rows] for name, value in fields.items() if isinstance(value, np.ndarray)}
        return Frames(**(fields | arrays | {"marks": MarkStates(*(array[rows] for array in self.marks))}))

    def rig_state(self, row: int) -> RigState:
        """State of rig and bit in a frame."""
        return RigState(*self.rig[row].tolist())
