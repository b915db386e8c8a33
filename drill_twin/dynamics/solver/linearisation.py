# SPDX-License-Identifier: Apache-2.0
"""The equations of motion at a given position, velocity and acceleration: residual, and tangents by each of them.

`build` of a formulation fills the system of a midpoint step, ``R = M a + f(u, v)`` with the derivative
``T(h) = M / h + C + h K`` by the mid-step velocity, C = df/dv and K = df/du. Seen as an instant, h = dt / 2 is small
and may be negative: the sum of T(h) and T(-h) is 2 C, their difference 2 (M / h + h K), and a second pair with another
h separates M from K. What a formulation evaluates between the ends of a step (wall, stretch) is then its value at the
instant, up to h^2.

The time loop converges with a simplified tangent too: the tangent of the bit's friction leaves out the change of its
coefficient with the slide. So the damping of the load at the bit is taken from differences
of that load alone.

Friction in a primal-dual form has its exact tangent when the dual variable has converged: from the second build at one
place on, whatever its half step.
"""

from collections.abc import Callable
from typing import Any

from drill_twin.core.arrays import Array
from drill_twin.core.compile.jit import kernel
from drill_twin.dynamics.solver.boundary import BIT, RESIDUAL, from_bit, to_bit, turn_row, turn_row_back
from drill_twin.dynamics.solver.interface import Effects, Formulation
from drill_twin.dynamics.solver.lateral import formulation as lateral
from drill_twin.dynamics.solver.lateral.linear_solver import NODE as LATERAL_NODE
from drill_twin.dynamics.solver.spatial import formulation as spatial
from drill_twin.dynamics.solver.spatial.linear_solver import NODE as SPATIAL_NODE
from drill_twin.dynamics.solver.state import State
from drill_twin.physics.model import Rod

SHORT, LONG = 1e-6, 2e-5
"""Half steps of the instant [s]: of the residual SHORT, of the damping LONG, of mass and stiffness both."""
CHANGE = 1e-6
"""Change of a velocity of the bit for the differences [m/s, 1/s, rad/s]."""
MASS, DAMPING, STIFFNESS = 0, 1, 2


@kernel
def set_instant(state: State, u: Array, v: Array, a: Array, half_step: float) -> None:
    """Set the state from which a half step half_step leads to position u and velocity v with acceleration a."""
    for i in range(u.shape[0]):
        for k in range(7):
            state.trial[i, k] = v[i, k]
            state.u[i, k] = u[i, k] - half_step * v[i, k]
            state.v[i, k] = v[i, k] - half_step * a[i, k]


@kernel
def lateral_right(scratch: Any, i: int, k: int) -> float:
    """Residual of unknown k of node i in the lateral form."""
    value: float = scratch.right[i, k]
    return value


@kernel
def spatial_right(scratch: Any, i: int, k: int) -> float:
    """As `lateral_right`, in the spatial form."""
    value: float = scratch.diagonal[i, k, SPATIAL_NODE]
    return value


def bind_lateral(form: Formulation, effects: Effects) -> Callable[..., None]:
    """The equations at an instant in the lateral form."""
    return _bind(form, effects.end_load, LATERAL_NODE, lateral.column, lateral_right)


def bind_spatial(form: Formulation, effects: Effects) -> Callable[..., None]:
    """The equations at an instant in the spatial form."""
    return _bind(form, effects.end_load, SPATIAL_NODE, spatial.column, spatial_right)


def _bind(form: Formulation, end_load: Any, count: int, column: Any, right: Any) -> Callable[..., None]:
    begin, build = form.begin, form.build

    @kernel
    def add_blocks(scratch: Any, out: Array, factor: float) -> None:
        """Add a multiple of the tangent, block rows [lower, own, upper], shape (n + 1, count, 3 count)."""
        last = out.shape[0] - 1
        for i in range(last + 1):
            for r in range(count):
                for c in range(count):
                    if i > 0:
                        out[i, r, c] += factor * scratch.lower[i - 1, r, c]
                    out[i, r, count + c] += factor * scratch.diagonal[i, r, c]
                    if i < last:
                        out[i, r, 2 * count + c] += factor * scratch.upper[i, r, c]

    @kernel
    def add_bit_damping(parameters: Any, rod: Rod, scratch: Any, state: State, own: Array) -> None:
        """Replace the damping of the load at the bit by its differences; shape (count, count), in the bit's frame.

        Called after `set_instant` for the half step LONG.
        """
        frame, trial, ends = state.bit_frame, state.trial, scratch.ends
        to_bit(frame, state.place[0], trial[0])
        turn_row(frame, state.v[0])
        for sign in range(2):
            ends[:] = 0.0
            half_step = LONG if sign == 0 else -LONG
            end_load(parameters, rod, scratch.command, 0.0, half_step, state.place, trial, state.v, ends)
            for k in range(count):
                for c in range(count):
                    own[k, c] -= 0.5 * ends[BIT, column(k), column(c)]
        for c in range(count):
            speed, before = trial[0, column(c)], state.v[0, column(c)]
            for sign in range(2):  # at one acceleration: of a body at the bit too
                way = 0.5 if sign == 0 else -0.5
                trial[0, column(c)] = speed + 2.0 * way * CHANGE
                state.v[0, column(c)] = before + 2.0 * way * CHANGE
                ends[:] = 0.0
                end_load(parameters, rod, scratch.command, 0.0, LONG, state.place, trial, state.v, ends)
                for k in range(count):
                    own[k, c] += way / CHANGE * ends[BIT, column(k), RESIDUAL]
            trial[0, column(c)], state.v[0, column(c)] = speed, before
        from_bit(frame, state.place[0], trial[0])
        turn_row_back(frame, state.v[0])

    @kernel
    def evaluate(
        parameters: Any,
        rod: Rod,
        scratch: Any,
        constrained: Array,
        state: State,
        u: Array,
        v: Array,
        a: Array,
        residual: Array,
        tangents: Array,
    ) -> None:
        """Fill `residual`, shape (n + 1, count), and `tangents`, shape (3, n + 1, count, 3 count): mass, damping,
        stiffness; rows and columns of constrained unknowns are without meaning.
        """
        tangents[:] = 0.0
        long2, short2 = LONG * LONG, SHORT * SHORT
        whole = long2 - short2
        for number in range(5):  # friction: the first build leads to the converged dual variable
            size = SHORT if number < 3 else LONG
            half_step = -size if number == 2 or number == 3 else size  # noqa: PLR1714  no set in a kernel
            set_instant(state, u, v, a, half_step)
            begin(scratch)
            build(parameters, rod, scratch, constrained, state, 0.0, half_step, number == 0, float(number))
            odd = 0.5 if half_step > 0.0 else -0.5  # of T(h): M / h + h K, at both sizes
            if number == 0:
                for i in range(residual.shape[0]):
                    for k in range(count):
                        residual[i, k] = right(scratch, i, k)
            elif size == SHORT:
                add_blocks(scratch, tangents[MASS], odd * SHORT * long2 / whole)
                add_blocks(scratch, tangents[STIFFNESS], -odd * SHORT / whole)
            else:
                add_blocks(scratch, tangents[MASS], -odd * LONG * short2 / whole)
                add_blocks(scratch, tangents[STIFFNESS], odd * LONG / whole)
                add_blocks(scratch, tangents[DAMPING], 0.5)
        add_bit_damping(parameters, rod, scratch, state, tangents[DAMPING, 0, :, count : 2 * count])

    return evaluate
