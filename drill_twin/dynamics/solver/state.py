# SPDX-License-Identifier: Apache-2.0
"""State of the time loop: what it carries from step to step, and what it counts."""

from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array, Triple
from drill_twin.core.compile.jit import kernel

CONVERGED, FAILED, TOO_MANY_HALVINGS, PAUSED = 0, 1, 2, -1

# Indices into State.clock: time [s], last step and the one before it [s], how many of `middle` and `earlier` are known,
# next Newton change per power of a change.
TIME, LAST_STEP, STEP_BEFORE, KNOWN, FACTOR = 0, 1, 2, 3, 4

# Indices into the array of counters; impulses of the reactions at the ends [N m s], [N s].
STEPS, ITERATIONS, HALVINGS, TORQUE_IMPULSE, HOOK_IMPULSE, BIT_IMPULSE, LOOSE_STEPS = 0, 1, 2, 3, 4, 5, 6
COUNTERS = 7

# Indices into the progress of an advance: Newton iterations left in this slice, and where it is paused the time reached
# [s], the next step [s] (0 where it is not), the largest number of halvings; 1 from the start of a frame to its end.
ITERATIONS_LEFT, REACHED, NEXT_STEP, MOST_HALVINGS, UNFINISHED = 0, 1, 2, 3, 4


class State(NamedTuple):
    """State of the string and mid-step velocities of the last steps; rows are (r, r', psi) per node from the bit."""

    u: np.ndarray  # (n + 1, 7) [m, -, rad]
    v: np.ndarray  # (n + 1, 7) [m/s, 1/s, rad/s]
    middle: np.ndarray  # (n + 1, 7) last mid-step velocity
    earlier: np.ndarray  # (n + 1, 7) the one before it
    trial: np.ndarray  # (n + 1, 7) mid-step velocity being sought
    place: np.ndarray  # (n + 1, 7) configuration at mid-step
    clock: np.ndarray  # (5,) see TIME
    bit_frame: np.ndarray  # (3, 4) see drill_twin.dynamics.solver.boundary; the identity in a straight hole


class StepControl(NamedTuple):
    """Nominal step, tolerances of Newton's method per kind of unknown, and how often the step may be halved."""

    step: float  # [s]
    position: float  # change of a node's position within a Newton step [m]
    angle: float  # change of slope and spin [rad]
    max_halvings: int  # of the step within a frame


def make_state(elements: int) -> State:
    """A state of zeros in a straight hole."""
    u, v, middle, earlier, trial, place = (np.zeros((elements + 1, 7)) for _ in range(6))
    return State(u, v, middle, earlier, trial, place, np.array([0.0, 0.0, 0.0, 0.0, np.inf]), np.eye(3, 4))


@kernel
def extrapolation_weights(clock: Array, step: float) -> Triple:
    """Weights of v, `middle` and `earlier` in the first guess of the next mid-step velocity.

    Linear in the last two mid-step velocities. A guess linear in v would be worse: waves faster than the step change
    sign from step to step in v, and average out at mid-step.
    """
    if clock[KNOWN] < 1.0:
        return 1.0, 0.0, 0.0
    if clock[KNOWN] < 2.0:
        return 0.0, 1.0, 0.0
    growth = (step + clock[LAST_STEP]) / (clock[LAST_STEP] + clock[STEP_BEFORE])
    return 0.0, 1.0 + growth, -growth


@kernel
def record_step(clock: Array, step: float) -> None:
    """Shift the history of steps by a step that was taken [s]."""
    clock[STEP_BEFORE], clock[LAST_STEP] = clock[LAST_STEP], step
    clock[KNOWN] = min(clock[KNOWN] + 1.0, 2.0)


@kernel
def record_failure(clock: Array) -> None:
    """Drop the older mid-step velocity from the extrapolation, which has failed."""
    clock[KNOWN] = min(clock[KNOWN], 1.0)
