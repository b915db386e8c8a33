# SPDX-License-Identifier: Apache-2.0
"""Frames of a twin: state of string, marks and rig, with reactions averaged over the frame."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.dynamics.discretisation.discretise import axis_at
from drill_twin.dynamics.solver import state
from drill_twin.dynamics.twin.dynamics import Dynamics
from drill_twin.dynamics.twin.frame import EnergyBalance, Frame, Frames, Intervention, MarkStates, RigState, StepStats
from drill_twin.dynamics.twin.frame_kernel import PUSHED, Past, Rows, Shown, States
from drill_twin.dynamics.twin.observation import DEPTH, PLACE, Observation, locate_marks
from drill_twin.dynamics.twin.packed_arrays import Copied
from drill_twin.physics.model.bit import BIT_TORQUE, BIT_WEIGHT, HOOK, TOP_TORQUE


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
        n, m = model.rod.arc.size, marks.size
        self._nodes = Copied((n, 3), (n, 3), (n, 3), (n,), (n,), (n,))  # as in `Frame` and `MarkStates`
        self._marks = Copied((m, 3), (m, 3), (m,), (m,), (m,), (m, 3))
        (_, _, tangents, _, _, wall_force), at = self._nodes.arrays, MarkStates(*self._marks.arrays)
        self.seen = Observation(
            tangents, wall_force, at.centre, at.position, at.velocity, at.spin, at.spin_rate,
            at.wall_force, np.array([-np.inf, 0.0]),
        )  # fmt: skip
        self.counters_before = dynamics.counters.copy()
        self.impulse_before = dynamics.parameters.drive.bit.impulse.copy()
        self._numbers = np.zeros(PUSHED + self.impulse_before.size)
        self._places, self._ends = model.places, dynamics.boundary_conditions
        ends = self._ends
        self._torque = PUSHED + TOP_TORQUE if ends.torque_driven else state.TORQUE_IMPULSE
        self._weight = PUSHED + BIT_WEIGHT if ends.bit_on_rock or ends.hoisted else state.BIT_IMPULSE
        self._hook = PUSHED + HOOK if ends.hoisted else state.HOOK_IMPULSE

    @property
    def deepest(self) -> tuple[float, int]:
        """Largest penetration of the string's surface into the wall [m], and its Gauss point."""
        return float(self.seen.deepest[DEPTH]), int(self.seen.deepest[PLACE])

    def shown(self, past: Past) -> Shown:
        """Arrays that take what `frame` needs beside the observation."""
        positions, velocities, _, spin, spin_rate, _ = self._nodes.arrays
        return Shown(positions, velocities, spin, spin_rate, self._numbers, past)

    def frame(
        self, seconds: float, wall_seconds: float, intervention: Intervention | None, energy: EnergyBalance | None
    ) -> Frame:
        """Make a frame of what was shown last.

        Args:
            seconds: Length of the frame [s].
            wall_seconds: Wall-clock time of its computation [s].
            intervention: Record of the step guard, if any.
            energy: Energy balance at its end, if any.
        """
        numbers, stress, ends = self._numbers.tolist(), self._dynamics.stress, self._ends
        time, depth, place, bit, bit_rate, top, top_rate, height, speed, load = numbers[state.COUNTERS : PUSHED]
        positions, velocities, tangents, spin, spin_rate, wall_force = self._nodes.copy()
        stats = StepStats(
            int(numbers[state.STEPS]), int(numbers[state.ITERATIONS]), int(numbers[state.HALVINGS]),
            int(numbers[state.LOOSE_STEPS]), wall_seconds,
        )  # fmt: skip
        rig = RigState(  # reactions averaged over the frame, as unresolved waves oscillate from step to step
            top, top_rate, numbers[self._torque] / seconds, bit, bit_rate, numbers[PUSHED + BIT_TORQUE] / seconds,
            numbers[self._weight] / seconds if ends.weight_at_top or ends.hoisted else load, height, speed,
            -load if ends.weight_at_top else numbers[self._hook] / seconds,
        )  # fmt: skip
        return Frame(
            time, positions, velocities, tangents, spin, spin_rate, wall_force, depth, self._places.item(int(place)),
            MarkStates(*self._marks.copy()), rig, stats, intervention, energy,
            None if stress is None else stress.copy(),
        )  # fmt: skip

    def frames(
        self, record: Record, count: int, seconds: float, wall_seconds: float, energy: EnergyBalance | None
    ) -> Frames:
        """Frames of a record; views of its arrays, which hold until it is filled again.

        Args:
            record: The record.
            count: Number of its rows that were filled.
            seconds: Length of a frame [s].
            wall_seconds: Wall-clock time of the computation of all [s].
            energy: Energy balance at the end of the last one, if any.
        """
        rows = Rows(*(array[:count] for array in record.rows))
        states = States(*(array[:count] for array in record.states))
        steps, iterations, cut, loose = (
            int(rows.counted[:, column].sum())
            for column in (state.STEPS, state.ITERATIONS, state.HALVINGS, state.LOOSE_STEPS)
        )
        marks = MarkStates(
            position=rows.position, velocity=states.velocity, spin=rows.spin, spin_rate=states.spin_rate,
            wall_force=rows.wall_force, centre=rows.centre,
        )  # fmt: skip
        rig = rig_rows(self._dynamics, rows, seconds)._asdict() | {
            "top_drive_angle": rows.ends[:, 1, 0], "bit_angle": rows.ends[:, 0, 0],
            "block_position": rows.ends[:, 1, 2], "block_velocity": states.v[:, -1, 2],
        }  # fmt: skip
        return Frames(
            time=rows.time, positions=states.u[..., 0:3], tangents=states.tangents, spin=states.u[..., 6],
            wall_force=states.wall_force, wall_depth=states.deepest[:, DEPTH],
            wall_depth_at=self._places[states.deepest[:, PLACE].astype(np.intp)], marks=marks,
            rig=np.stack([rig[name] for name in RigState._fields], axis=-1),
            stats=StepStats(steps, iterations, cut, loose, wall_seconds),
            interventions=tuple(record.interventions.values()), energy=energy,
            stress=None if self._dynamics.stress is None else states.stress, u=states.u, v=states.v,
        )  # fmt: skip


class Record(NamedTuple):
    """Frames as the compiled loop records them, for `Observer.frames`."""

    rows: Rows
    states: States
    interventions: dict[int, Intervention]
    """Records of the step guard by row."""

    @property
    def size(self) -> int:
        """Number of frames that it takes."""
        return len(self.rows.time)


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
