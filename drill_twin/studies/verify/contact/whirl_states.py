# SPDX-License-Identifier: Apache-2.0
"""Steady whirl states (`drill-twin whirl-states`) against pure rolling and against the simulation in time."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from drill_twin.base.arrays import Array
from drill_twin.rotordynamics.equations import EquationsOfMotion
from drill_twin.rotordynamics.steady.whirl_states import WhirlState, whirl_states
from drill_twin.scene import Scene
from drill_twin.schedule.command import Command
from drill_twin.studies.verify.case import FORMS, case
from drill_twin.studies.verify.dynamics.modes import SET
from drill_twin.studies.verify.row import Row
from drill_twin.studies.verify.scenes import DIAMETER, quiet_scene
from drill_twin.twin.dynamics import Dynamics

LATERAL = FORMS[1]
TURNS = 100
FRAME = 0.01
ROD: dict[str, Any] = {
    "gravity": {"magnitude": 9.81},
    "internal_damping": {"bending_time": 48e-3},
    "drag": {"linear": 0.0032},
    "wall": {"stiffness": 1e7, "restitution": 0.5},
    "wall_friction": {"coefficient": 0.308, "decay": 1.0},
}
"""Effects of pa6_calibrated, without imperfections."""
TIME_LOOP = "the time loop"


@case(forms=(LATERAL,), long=True)
def rolling_state() -> Iterator[Row]:
    """Backward rolling without slip, under sufficient friction: an equilibrium in the frame that turns with it.

    The orbit is taken at the node farthest out, which is not where the contact is sampled.
    """
    effects = {"internal_damping": {"bending_time": 2e-3}, "drag": {"linear": 0.02}, "wall": {"stiffness": 1e7},
               "wall_friction": {"coefficient": 0.5}}  # fmt: skip
    scene = quiet_scene(effects, of=SET, form=LATERAL, bit_end="guided", radius=0.04, elements=16)
    found = whirl_states(EquationsOfMotion(scene), Command(30.0, math.tau), random_starts=0)
    state = next(one for one in found if one.kind == "backward rolling")
    exact = -0.5 * DIAMETER / float(state.whirl.radius.max())
    yield Row("whirl over rotation [-]", "-r_pipe / r_orbit", "no slip; Vandiver, Nicholson and Shyu 1990", exact,
              state.ratio, 2e-3)  # fmt: skip
    yield Row("unstable [0 or 1]", "0", TIME_LOOP, 0.0, float(not state.is_stable), 0.5, relative=False)


def follow(scene: Scene, state: WhirlState, seconds: float) -> tuple[Array, Array, Array]:
    """Times [s], distance from a state over the clearance, and angle [rad] of a simulation that begins on it."""
    dynamics, command = Dynamics(scene), state.whirl.command
    u, v, _ = state.whirl.motion
    start, clearance = u[:, 0] + 1j * u[:, 1], float(dynamics.model.wellbore.clearance.min())
    dynamics.begin(u, v, command)
    found = []
    for _ in range(round(seconds / FRAME)):
        dynamics.advance(np.array([command.weight_on_bit, command.rotation]), FRAME)
        now = dynamics.unknowns[0][:, 0] + 1j * dynamics.unknowns[0][:, 1]
        turn = np.vdot(start, now)
        found.append((dynamics.time, np.abs(now - start * turn / abs(turn)).max() / clearance, np.angle(turn)))
    times, apart, angle = np.array(found).T
    return times, apart, np.unwrap(angle)


@case(forms=(LATERAL,), long=True)
def simulation_on_a_stable_state() -> Iterator[Row]:
    """A simulation that begins on a stable forward whirl, 40 N at 6.5 rev/s, stays on it for 100 turns of the string.

    The midpoint rule with a step of 1 ms shortens a whirl of 5.4 Hz by (omega dt)^2 / 12 = 1e-4.
    """
    effects = {**ROD, "bit_friction": {"coefficient": 0.087, "radius": 5.5e-3}}
    scene = quiet_scene(effects, of=SET, form=LATERAL, bit_end="sliding", radius=0.09, elements=16, step=1e-3)
    command = Command(40.0, 6.5 * math.tau)
    state = next(one for one in whirl_states(EquationsOfMotion(scene), command, random_starts=1) if one.is_stable)
    times, apart, angle = follow(scene, state, TURNS / 6.5)
    speed = float((angle[-1] - angle[0]) / (times[-1] - times[0]))
    yield Row("largest distance from the state in 100 turns, over the clearance [-]", "0", TIME_LOOP, 0.0,
              float(apart.max()), 1e-3, relative=False)  # fmt: skip
    yield Row("whirl speed [rad/s]", "omega of the state", TIME_LOOP, state.whirl.omega, speed, 3e-4)


@case(forms=(LATERAL,), long=True)
def simulation_off_an_unstable_state() -> Iterator[Row]:
    """A simulation that begins on an unstable whirl, 20 N at 2 rev/s with a guided bit, leaves it at the computed rate.

    It is left from rounding errors on; the rate is fitted between 1e-4 and 5e-3 of the clearance, over about four
    times e, with the oscillation of the disturbance on it.
    """
    scene = quiet_scene(ROD, of=SET, form=LATERAL, bit_end="guided", radius=0.09, elements=16, step=1e-3)
    command = Command(20.0, 2.0 * math.tau)
    found = whirl_states(EquationsOfMotion(scene), command)
    state = min(found, key=lambda one: abs(one.ratio - 0.54))
    times, apart, _ = follow(scene, state, 14.0)
    grows = (apart > 1e-4) & (apart < 5e-3)
    rate = float(np.polyfit(times[grows], np.log(apart[grows]), 1)[0])
    yield Row("growth [1/s]", "largest real part of the eigenvalues", TIME_LOOP, state.growth, rate,
              0.03)  # fmt: skip
