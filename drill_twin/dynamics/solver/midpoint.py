# SPDX-License-Identifier: Apache-2.0
"""The implicit midpoint rule with Newton's method: the whole time loop in one compiled function.

``M (v - v_n) / (dt/2) + forces(u_n + dt/2 v, v) = 0`` for the mid-step velocity v, then ``u += dt v`` and
``v_n+1 = 2 v - v_n``. Second order, no step limit for linear problems, keeps linear and angular momentum to round-off
and an undamped rod's energy without drift (Hairer, Lubich and Wanner 2006, ch. IV and VI). Its state is configuration
and velocity alone, so the step may change at any time: where Newton's method fails it is halved and counted, and it
doubles after each success up to the nominal one.

A formulation, `drill_twin.dynamics.solver.spatial` or `drill_twin.dynamics.solver.lateral`, decides the unknowns of a
node.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.compile.jit import kernel
from drill_twin.dynamics.solver.boundary import from_bit, set_points, to_bit
from drill_twin.dynamics.solver.interface import Effects, Formulation
from drill_twin.dynamics.solver.state import (
    CONVERGED,
    FACTOR,
    FAILED,
    HALVINGS,
    ITERATIONS,
    ITERATIONS_LEFT,
    LOOSE_STEPS,
    MOST_HALVINGS,
    NEXT_STEP,
    PAUSED,
    REACHED,
    STEPS,
    TIME,
    TOO_MANY_HALVINGS,
    State,
    StepControl,
    record_failure,
    record_step,
)
from drill_twin.physics.model import Rod

MAX_ITERATIONS = 12
CONVERGENCE_SAFETY = 0.1  # a next change foreseen below this share of the tolerance need not be computed
# Where a contact point sticks and slips in turn from one iteration to the next, the iteration does not converge: the
# changes stay small, of the order of the tolerance. Such a step is accepted, and counted as loose.
MIN_ITERATIONS_FOR_STALL, STALL_RATIO, LOOSE_FACTOR = 3, 0.25, 10.0
LARGEST_MISS = 0.01  # of dry friction at the bit: periods of stick-slip are within 2e-4 of the periods at 1e-3
ROUNDING = 2.0 * np.finfo(float).eps  # of a time, relative
LARGEST_FACTOR = 1e6  # of the convergence estimate that is carried on
SMALLEST_SHARE = 1.0 / 4096.0  # of the nominal step; below, the step has failed


@kernel
def no_audit(
    parameters: Any, rod: Rod, scratch: Any, constrained: Array, state: State, time: float, half_step: float
) -> None:
    """Stand in for the energy audit where it is off; leaves nothing in the machine code."""


@kernel
def no_end(parameters: Any, rod: Rod, state: State) -> None:
    """As `no_audit`."""


def bind(form: Formulation, effects: Effects, audit_step: Any = None, close_step: Any = None) -> Callable[..., int]:
    """The time loop for one formulation and a set of effects.

    Args:
        form: The formulation.
        effects: The effects.
        audit_step: Updates the energy ledger for a step that has converged (`drill_twin.dynamics.audit.step_audit`);
            None: `no_audit`.
        close_step: Completes the ledger after the step has been taken; None: `no_end`.
    """
    audit_step, close_step = audit_step or no_audit, close_step or no_end  # a default would be no compiled function yet
    begin, predict, build, solve, correct, accept, finish, order = form
    prescribed_motion, after_step, missed = effects.prescribed_motion, effects.after_step, effects.missed

    @kernel
    def newton(
        parameters: Any,
        rod: Rod,
        scratch: Any,
        constrained: Array,
        state: State,
        control: StepControl,
        time: float,
        half_step: float,
        counters: Array,
    ) -> int:
        """Find the mid-step velocity in ``state.trial``; returns the iterations used, negative if it failed."""
        clock, before = state.clock, 1.0
        for iteration in range(MAX_ITERATIONS):
            first_iteration, number = iteration == 0, counters[ITERATIONS] + iteration
            build(parameters, rod, scratch, constrained, state, time, half_step, first_iteration, number)
            if not solve(scratch):
                return -1 - iteration
            size = correct(scratch, state, control, half_step)
            if not np.isfinite(size):
                return -1 - iteration
            if iteration > 0:
                # The next change is a factor times a power of this one; a larger earlier factor halves per iteration.
                clock[FACTOR] = max(size / before**order, 0.5 * min(clock[FACTOR], LARGEST_FACTOR))
            small = size < 1.0 or size**order * clock[FACTOR] < CONVERGENCE_SAFETY
            if small and missed(parameters, state.trial) < LARGEST_MISS:
                return iteration + 1
            if (
                iteration >= MIN_ITERATIONS_FOR_STALL
                and not small
                and size < LOOSE_FACTOR
                and size > STALL_RATIO * before
            ):
                counters[LOOSE_STEPS] += 1
                return iteration + 1
            before = size
        return -MAX_ITERATIONS

    @kernel
    def advance(
        parameters: Any,
        rod: Rod,
        scratch: Any,
        constrained: Array,
        state: State,
        control: StepControl,
        command0: Array,
        command1: Array,
        start: float,
        end: float,
        counters: Array,
        progress: Array,
    ) -> int:
        """Move the string from time `start` to `end`; the set-points go linearly from `command0` to `command1`.

        Called again with the same arguments after a pause, it goes on from there (`drill_twin.dynamics.solver.slices`).

        Returns:
            CONVERGED; PAUSED at the end of the slice; FAILED if a step below 1/4096 of the nominal one was needed;
            TOO_MANY_HALVINGS if it was halved more often than the control allows.
        """
        count = max(1, int(np.ceil((end - start) / control.step - 1e-9 - ROUNDING * end / control.step)))
        nominal = (end - start) / count
        last = end - 1e-9 * nominal - ROUNDING * count * end  # late in a long run, times are rounded by more than 1e-9
        step = nominal
        time = start
        most_halvings = counters[HALVINGS] + control.max_halvings
        if progress[NEXT_STEP] > 0.0:
            time, step, most_halvings = progress[REACHED], progress[NEXT_STEP], progress[MOST_HALVINGS]
            progress[NEXT_STEP] = 0.0
        else:
            begin(scratch)
        while time < last:
            if progress[ITERATIONS_LEFT] <= 0.0:
                progress[REACHED], progress[NEXT_STEP], progress[MOST_HALVINGS] = time, step, most_halvings
                return PAUSED
            step = min(step, end - time)
            half_step = 0.5 * step
            set_points(command0, command1, (time + half_step - start) / (end - start), scratch.command)
            predict(scratch, constrained, state, half_step)
            prescribed_motion(parameters, rod, time + half_step, state.trial)
            iterations = newton(
                parameters, rod, scratch, constrained, state, control, time + half_step, half_step, counters
            )
            counters[ITERATIONS] += abs(iterations)
            progress[ITERATIONS_LEFT] -= abs(iterations)
            if iterations < 0:
                counters[HALVINGS] += 1
                record_failure(state.clock)
                step *= 0.5
                if step < SMALLEST_SHARE * nominal:
                    return FAILED
                if counters[HALVINGS] > most_halvings:
                    return TOO_MANY_HALVINGS
                continue
            audit_step(parameters, rod, scratch, constrained, state, time + half_step, half_step)
            time += step
            set_points(command0, command1, (time - start) / (end - start), scratch.command)
            accept(scratch, constrained, state, counters, half_step)
            counters[STEPS] += 1
            record_step(state.clock, step)
            to_bit(state.bit_frame, state.u[0], state.v[0])
            after_step(parameters, rod, scratch.command, time, step, state.u, state.v)
            from_bit(state.bit_frame, state.u[0], state.v[0])
            close_step(parameters, rod, state)
            step = min(nominal, 2.0 * step)
        state.clock[TIME] = end
        finish(rod, state)
        return CONVERGED

    return advance
