# SPDX-License-Identifier: Apache-2.0
"""Frames of a twin: state of string, marks and rig, with reactions averaged over the frame."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from drill_twin.base.arrays import Array
from drill_twin.discretisation.discretise import axis_at
from drill_twin.model.bit import BIT_TORQUE, BIT_WEIGHT, HOOK, TOP_TORQUE
from drill_twin.solver import state
from drill_twin.twin.dynamics import Dynamics
from drill_twin.twin.frame import EnergyBalance, Frame, Intervention, MarkStates, RigState, StepStats
from drill_twin.twin.frame_kernel import Rows
from drill_twin.twin.observation import DEPTH, PLACE, locate_marks, make_observation


class Observer:
    """Makes the frames of one twin.

    Attributes:
        marks: The marks.
        seen: The last observation, made by the frame loop.
        counters_before: Counters at the start of the frame.
        impulse_before: Impulses of the reactions at the start of the frame.
    """

    def __init__(self, dynamics: Dynamics) -> None:
        self._dynamics = dynamics
        scene, model = dynamics.scene, dynamics.model
        marks = np.array([mark.distance_from_bit for mark in scene.string.marks])
        offset = np.array([mark.wall_offset for mark in scene.mark_table])
        self.marks = locate_marks(model.rod, marks, offset, axis_at(scene, scene.length - marks))
        self.seen = make_observation(model.rod.arc.size, marks.size)
        self.counters_before = dynamics.counters.copy()
        self.impulse_before = dynamics.parameters.drive.bit.impulse.copy()
        self._places = model.places

    @property
    def deepest(self) -> tuple[float, int]:
        """Largest penetration of the string's surface into the wall [m], and its Gauss point."""
        return float(self.seen.deepest[DEPTH]), int(self.seen.deepest[PLACE])

    def frame(
        self, seconds: float, wall_seconds: float, intervention: Intervention | None, energy: EnergyBalance | None
    ) -> Frame:
        """Make a frame of the last observation.

        Args:
            seconds: Length of the frame [s].
            wall_seconds: Wall-clock time of its computation [s].
            intervention: Record of the step guard, if any.
            energy: Energy balance at its end, if any.
        """
        dynamics, seen = self._dynamics, self.seen
        u, v = dynamics.unknowns
        counted = dynamics.counters - self.counters_before
        pushed = dynamics.parameters.drive.bit.impulse - self.impulse_before
        marks = MarkStates(
            position=seen.position.copy(), velocity=seen.velocity.copy(), spin=seen.spin.copy(),
            spin_rate=seen.spin_rate.copy(), wall_force=seen.mark_force.copy(), centre=seen.centre.copy(),
        )  # fmt: skip
        count = counted.tolist()
        stats = StepStats(
            steps=int(count[state.STEPS]), iterations=int(count[state.ITERATIONS]),
            cut_steps=int(count[state.HALVINGS]), loose_steps=int(count[state.LOOSE_STEPS]),
            wall_seconds=wall_seconds,
        )  # fmt: skip
        return Frame(
            time=dynamics.time, positions=u[:, 0:3].copy(), velocities=v[:, 0:3].copy(), tangents=seen.tangents.copy(),
            spin=u[:, 6].copy(), spin_rate=v[:, 6].copy(), wall_force=seen.wall_force.copy(),
            wall_depth=float(seen.deepest[DEPTH]),
            wall_depth_at=float(self._places[int(seen.deepest[PLACE])]),
            marks=marks, rig=self._rig(counted / seconds, pushed / seconds), stats=stats, intervention=intervention,
            energy=energy, stress=None if dynamics.stress is None else dynamics.stress.copy(),
        )  # fmt: skip

    def _rig(self, mean: Array, pushed: Array) -> RigState:
        """State of the rig, with reactions averaged over the frame, as unresolved waves oscillate from step to step."""
        dynamics = self._dynamics
        (u, v), ends, load = dynamics.unknowns, dynamics.boundary_conditions, float(dynamics.command[0])
        bit, bit_rate, top, top_rate = u[0].tolist(), v[0].tolist(), u[-1].tolist(), v[-1].tolist()
        reaction, force = mean.tolist(), pushed.tolist()
        weight = force[BIT_WEIGHT] if ends.bit_on_rock or ends.hoisted else reaction[state.BIT_IMPULSE]
        hookload = force[HOOK] if ends.hoisted else reaction[state.HOOK_IMPULSE]
        return RigState(
            top_drive_angle=top[6], top_drive_speed=top_rate[6],
            top_drive_torque=force[TOP_TORQUE] if ends.torque_driven else reaction[state.TORQUE_IMPULSE],
            bit_angle=bit[6], bit_speed=bit_rate[6], bit_torque=force[BIT_TORQUE],
            bit_force=weight if ends.weight_at_top or ends.hoisted else load,
            block_position=top[2], block_velocity=top_rate[2],
            hookload=-load if ends.weight_at_top else hookload,
        )  # fmt: skip


class RigRows(NamedTuple):
    """Rig and bit over recorded frames, each of shape (F,); fields as in `RigState`."""

    top_drive_speed: Array
    top_drive_torque: Array
    bit_speed: Array
    bit_torque: Array
    bit_force: Array
    hookload: Array


def rig_rows(dynamics: Dynamics, rows: Rows, seconds: float) -> RigRows:
    """Rig and bit over recorded frames of a length [s]."""
    mean, pushed, ends = rows.counted / seconds, rows.pushed / seconds, dynamics.boundary_conditions
    load = rows.command[:, 0]
    weight = pushed[:, BIT_WEIGHT] if ends.bit_on_rock or ends.hoisted else mean[:, state.BIT_IMPULSE]
    hookload = pushed[:, HOOK] if ends.hoisted else mean[:, state.HOOK_IMPULSE]
    return RigRows(
        top_drive_speed=rows.ends[:, 1, 1],
        top_drive_torque=pushed[:, TOP_TORQUE] if ends.torque_driven else mean[:, state.TORQUE_IMPULSE],
        bit_speed=rows.ends[:, 0, 1],
        bit_torque=pushed[:, BIT_TORQUE],
        bit_force=weight if ends.weight_at_top or ends.hoisted else load,
        hookload=-load if ends.weight_at_top else hookload,
    )
