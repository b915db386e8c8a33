# SPDX-License-Identifier: Apache-2.0
"""What is published of a twin: its string, marks and rig at the end of a frame."""

from __future__ import annotations

import numpy as np

from drill_twin.base.arrays import Array
from drill_twin.discretisation.discretise import axis_at
from drill_twin.model.bit import BIT_TORQUE, BIT_WEIGHT, TOP_TORQUE
from drill_twin.solver import state
from drill_twin.twin.dynamics import Dynamics
from drill_twin.twin.frame import EnergyBalance, Frame, Intervention, MarkStates, RigState, StepStats
from drill_twin.twin.observation import DEEPEST, WHERE, make_probe, make_sight, observe


class Observer:
    """Reads one twin, frame by frame."""

    def __init__(self, dynamics: Dynamics) -> None:
        self._machine = dynamics
        scene, model = dynamics.scene, dynamics.model
        marks = np.array([mark.distance_from_bit for mark in scene.string.marks])
        offset = np.array([mark.wall_offset for mark in scene.mark_table])
        self._probe = make_probe(model.rod, marks, offset, axis_at(scene, scene.length - marks))
        self._places = model.places
        self._impulse = dynamics.parameters.drive.bit.impulse
        self.begin()

    def begin(self) -> None:
        """A frame begins here: reactions are averaged, and costs counted, from now on."""
        self._counted, self._pushed = self._machine.counters.copy(), self._impulse.copy()

    def look(self) -> tuple[float, int]:
        """See what has become of the string.

        Returns:
            How far its surface is beyond the wall where it is most so [m], and the Gauss point where that is.
        """
        dynamics = self._machine
        u, v = dynamics.unknowns
        self._sight = make_sight(u.shape[0], self._probe.element.size)
        observe(dynamics.rod, dynamics.model.wellbore, dynamics.wall, u, v, self._probe, self._sight)
        return float(self._sight.nearness[DEEPEST]), int(self._sight.nearness[WHERE])

    def frame(
        self, seconds: float, wall_seconds: float, intervention: Intervention | None, energy: EnergyBalance | None
    ) -> Frame:
        """What was last looked at, as a frame.

        Args:
            seconds: Length of the frame [s].
            wall_seconds: What it has taken to compute [s].
            intervention: What the guard did in it.
            energy: The energy balance after it.
        """
        sight, (u, v) = self._sight, self._machine.unknowns
        counted, pushed = self._machine.counters - self._counted, self._impulse - self._pushed
        marks = MarkStates(
            position=sight.position, velocity=sight.velocity, spin=sight.spin, spin_rate=sight.spin_rate,
            wall_force=sight.mark_force, centre=sight.centre,
        )  # fmt: skip
        stats = StepStats(
            steps=int(counted[state.STEPS]), iterations=int(counted[state.ITERATIONS]),
            cut_steps=int(counted[state.HALVINGS]), loose_steps=int(counted[state.LOOSE_STEPS]),
            wall_seconds=wall_seconds,
        )  # fmt: skip
        return Frame(
            time=self._machine.time, positions=u[:, 0:3].copy(), velocities=v[:, 0:3].copy(), tangents=sight.tangents,
            spin=u[:, 6].copy(), spin_rate=v[:, 6].copy(), wall_force=sight.wall_force,
            wall_depth=float(sight.nearness[DEEPEST]),
            wall_depth_at=float(self._places[int(sight.nearness[WHERE])]),
            marks=marks, rig=self._rig(counted / seconds, pushed / seconds), stats=stats, intervention=intervention,
            energy=energy,
        )  # fmt: skip

    def _rig(self, mean: Array, pushed: Array) -> RigState:
        """The rig, with reactions averaged over the frame: single steps carry the ringing of unresolved waves."""
        (u, v), ends, load = self._machine.unknowns, self._machine.ends, float(self._machine.command[0])
        weight = pushed[BIT_WEIGHT] if ends.on_rock else mean[state.BIT_IMPULSE]
        return RigState(
            top_drive_angle=float(u[-1, 6]), top_drive_speed=float(v[-1, 6]),
            top_drive_torque=float(pushed[TOP_TORQUE] if ends.driven else mean[state.TORQUE_IMPULSE]),
            bit_angle=float(u[0, 6]), bit_speed=float(v[0, 6]), bit_torque=float(pushed[BIT_TORQUE]),
            bit_force=float(weight) if ends.from_top else load,
            block_position=float(u[-1, 2]), block_velocity=float(v[-1, 2]),
            hookload=-load if ends.from_top else float(mean[state.HOOK_IMPULSE]),
        )  # fmt: skip
