# SPDX-License-Identifier: Apache-2.0
"""What one published step of the twin looks like: arrays of the whole string, its marks and the rig.

Nodes count from the bit (0) to the top clamp (n). Vectors are in the frame `hole`: origin at the top clamp, z up along
the hole's axis there, x to the low side. Where the hole is curved, marks are told in the frame of the hole at their
depth instead: x and y from its axis, z along it (minus the measured depth); in a straight hole that is the same. All
values are SI, float64, and fresh copies that the receiver may keep.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from drill_twin.base.arrays import Array


@dataclass(frozen=True, eq=False)
class MarkStates:
    """State of the marks, in the order of the scene; m marks."""

    position: Array
    """Positions of the marked points [m], shape (m, 3); on the wall they turn with the spin."""
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


@dataclass(frozen=True)
class RigState:
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
    """Height of the travelling block over its start [m]."""
    block_velocity: float
    """Velocity of the travelling block [m/s], positive up."""
    hookload: float
    """Force that holds the string at the top [N]."""


@dataclass(frozen=True)
class StepStats:
    """What one published step cost."""

    steps: int
    """Time steps taken."""
    iterations: int
    """Newton iterations of all of them."""
    cut_steps: int
    """Steps that had to be halved."""
    loose_steps: int
    """Steps taken within ten tolerances instead of one, as places on the wall only flickered between stick and slip."""
    wall_seconds: float
    """Wall-clock time of the computation [s]."""


COUNTS = ("steps", "cut_steps", "loose_steps")
"""Those of `StepStats` that diagnostics and summary give for a run."""


@dataclass(frozen=True)
class Intervention:
    """A frame that the guard took back and had done again with a smaller step."""

    time: float
    """Simulated time of the last good frame before it [s]."""
    kind: str
    """What was violated: finite, newton, speed, strain, fold, slope, penetration or energy."""
    node: int
    """Node where it was worst."""
    distance_from_bit: float
    """Its distance from the bit [m]."""
    text: str
    """What happened, in words."""
    tries: int
    """How often the frame was done again."""
    step: float
    """Time step that at last was small enough [s]."""


@dataclass(frozen=True)
class EnergyBalance:
    """Where the energy of the string has come from and gone to since the start of the run [J]."""

    stored: Mapping[str, float]
    """What the string holds now: kinetic, bending, stretch, torsion, gravity (since the start) and wall."""
    work: Mapping[str, float]
    """What each effect and the rig have done on the string: weight_on_bit, top_drive, top_clamp, and by effect. What
    the wall gives back is in it, and so is what turns into heat, as negative work."""
    dissipated: Mapping[str, float]
    """What has turned into heat, by effect."""
    residual: float
    """Energy that nothing accounts for: gained if positive."""
    scale: float
    """Largest energy on the move so far, to judge the residual by: kinetic, change of the other stores, and heat."""
    newton: float
    """The part of the residual that the iteration's tolerance makes up."""

    @property
    def share(self) -> float:
        """Residual over scale."""
        return self.residual / self.scale


@dataclass(frozen=True, eq=False)
class Frame:
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
    """How far the string's surface is beyond the wall where it is most so [m], whether the scene lists a wall or not;
    negative while all of it is clear of the wall. Sampled at the Gauss points, at this instant."""
    wall_depth_at: float
    """Distance of that place from the bit [m]."""
    marks: MarkStates
    """The marks."""
    rig: RigState
    """The rig."""
    stats: StepStats
    """The cost."""
    intervention: Intervention | None = None
    """What the guard did; None where nothing had to be done."""
    energy: EnergyBalance | None = None
    """The energy balance; None where the scene asks for no audit."""
