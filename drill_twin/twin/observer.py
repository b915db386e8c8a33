# SPDX-License-Identifier: Apache-2.0
"""Frames of a twin: state of string, marks and rig, with reactions averaged over the frame."""

from __future__ import annotations

import numpy as np

from drill_twin.base.arrays import Array
from drill_twin.discretisation.discretise import axis_at
from drill_twin.model.bit import BIT_TORQUE, BIT_WEIGHT, TOP_TORQUE
from drill_twin.solver import state
from drill_twin.twin.dynamics import Dynamics
from drill_twin.twin.frame import EnergyBalance, Frame, Intervention, MarkStates, RigState, StepStats
from drill_twin.twin.observation import DEPTH, PLACE, locate_marks, make_observation, observe


class Observer:
    """Makes the frames of one twin."""

    def __init__(self, dynamics: Dynamics) -> None:
        self._dynamics = dynamics
        scene, model = dynamics.scene, dynamics.model
        marks = np.array([mark.distance_from_bit for mark in scene.string.marks])
        offset = np.array([mark.wall_offset for mark in scene.mark_table])
        self._marks = locate_marks(model.rod, marks, offset, axis_at(scene, scene.length - marks))
        self._places = model.places
        self._impulse = dynamics.parameters.drive.bit.impulse
        self.begin_frame()

    def begin_frame(self) -> None:
        """Begin a frame: reactions are averaged and steps counted from this instant."""
        self._counters_at_start, self._impulse_at_start = self._dynamics.counters.copy(), self._impulse.copy()

    def observe(self) -> tuple[float, int]:
        """Observe the current state.

        Returns:
            Largest penetration of the string's surface into the wall [m], and its Gauss point.
        """
        dynamics = self._dynamics
        u, v = dynamics.unknowns
        self._observation = make_observation(u.shape[0], self._marks.element.size)
        observe(dynamics.rod, dynamics.model.wellbore, dynamics.wall, u, v, self._marks, self._observation)
        return float(self._observation.deepest[DEPTH]), int(self._observation.deepest[PLACE])

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
        seen, (u, v) = self._observation, self._dynamics.unknowns
        counted, pushed = self._dynamics.counters - self._counters_at_start, self._impulse - self._impulse_at_start
        marks = MarkStates(
            position=seen.position, velocity=seen.velocity, spin=seen.spin, spin_rate=seen.spin_rate,
            wall_force=seen.mark_force, centre=seen.centre,
        )  # fmt: skip
        stats = StepStats(
            steps=int(counted[state.STEPS]), iterations=int(counted[state.ITERATIONS]),
            cut_steps=int(counted[state.HALVINGS]), loose_steps=int(counted[state.LOOSE_STEPS]),
            wall_seconds=wall_seconds,
        )  # fmt: skip
        return Frame(
            time=self._dynamics.time, positions=u[:, 0:3].copy(), velocities=v[:, 0:3].copy(), tangents=seen.tangents,
            spin=u[:, 6].copy(), spin_rate=v[:, 6].copy(), wall_force=seen.wall_force,
            wall_depth=float(seen.deepest[DEPTH]),
            wall_depth_at=float(self._places[int(seen.deepest[PLACE])]),
            marks=marks, rig=self._rig(counted / seconds, pushed / seconds), stats=stats, intervention=intervention,
            energy=energy,
        )  # fmt: skip

    def _rig(self, mean: Array, pushed: Array) -> RigState:
        """State of the rig, with reactions averaged over the frame, as unresolved waves oscillate from step to step."""
        dynamics = self._dynamics
        (u, v), ends, load = dynamics.unknowns, dynamics.boundary_conditions, float(dynamics.command[0])
        weight = pushed[BIT_WEIGHT] if ends.bit_on_rock else mean[state.BIT_IMPULSE]
        return RigState(
            top_drive_angle=float(u[-1, 6]), top_drive_speed=float(v[-1, 6]),
            top_drive_torque=float(pushed[TOP_TORQUE] if ends.torque_driven else mean[state.TORQUE_IMPULSE]),
            bit_angle=float(u[0, 6]), bit_speed=float(v[0, 6]), bit_torque=float(pushed[BIT_TORQUE]),
            bit_force=float(weight) if ends.weight_at_top else load,
            block_position=float(u[-1, 2]), block_velocity=float(v[-1, 2]),
            hookload=-load if ends.weight_at_top else float(mean[state.HOOK_IMPULSE]),
        )  # fmt: skip
