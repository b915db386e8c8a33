# SPDX-License-Identifier: Apache-2.0
"""The equations of motion at a given position, velocity and acceleration: residual, and tangents by each of them.

`build` of a formulation fills the system of a midpoint step, ``R = M a + f(u, v)`` with the derivative
``T(h) = M / h + C + h K`` by the mid-step velocity, C = df/dv and K = df/du. Seen as an instant, h = dt / 2 is small
and may be negative: the sum of T(h) and T(-h) is 2 C, their difference 2 (M / h + h K), and a second pair with another
h separates M from K. What a formulation evaluates between the ends of a step (wall, stretch) is then its value at the
instant, up to h^2.

The time loop can do with a simplified tangent where Newton's method converges with it; that of the bit's friction
leaves out the change of its coefficient with the slide. So the damping at the bit is taken from differences.

Friction in a primal-dual form has its exact tangent when the dual variable has converged: the second of two builds at
one place.
"""

from collections.abc import Callable
from typing import Any

from drill_twin.base.arrays import Array
from drill_twin.base.jit import kernel
from drill_twin.model.mesh import Rod
from drill_twin.solver.interface import Formulation
from drill_twin.solver.lateral import formulation as lateral
from drill_twin.solver.lateral.linear_solver import NODE as LATERAL_NODE
from drill_twin.solver.spatial import formulation as spatial
from drill_twin.solver.spatial.linear_solver import NODE as SPATIAL_NODE
from drill_twin.solver.state import State

SHORT, LONG = 1e-6, 2e-5
"""Half steps of the instant [s]: of the residual SHORT, of the damping LONG, of mass and stiffness both."""
CHANGE = 1e-6
"""Change of a velocity of the bit for the differences [m/s, 1/s, rad/s]."""
MASS, DAMPING, STIFFNESS = 0, 1, 2


@kernel
def set_instant(state: State, u: Array, v: Array, a: Array, h2: float) -> None:
    """Set the state from which a half step h2 leads to position u and velocity v with acceleration a."""
    for i in range(u.shape[0]):
        for k in range(7):
            state.trial[i, k] = v[i, k]
            state.u[i, k] = u[i, k] - h2 * v[i, k]
            state.v[i, k] = v[i, k] - h2 * a[i, k]


@kernel
def lateral_right(work: Any, i: int, k: int) -> float:
    """Residual of unknown k of node i in the lateral form."""
    value: float = work.right[i, k]
    return value


@kernel
def spatial_right(work: Any, i: int, k: int) -> float:
    """As `lateral_right`, in the spatial form."""
    value: float = work.diagonal[i, k, SPATIAL_NODE]
    return value


def bind_lateral(form: Formulation) -> Callable[..., None]:
    """The equations at an instant in the lateral form."""
    return _bind(form, LATERAL_NODE, lateral.column, lateral_right)


def bind_spatial(form: Formulation) -> Callable[..., None]:
    """The equations at an instant in the spatial form."""
    return _bind(form, SPATIAL_NODE, spatial.column, spatial_right)


def _bind(form: Formulation, count: int, column: Any, right: Any) -> Callable[..., None]:
    begin, build = form.begin, form.build

    @kernel
    def add_blocks(work: Any, out: Array, factor: float) -> None:
        """Add a multiple of the tangent, block rows [lower, own, upper], shape (n + 1, count, 3 count)."""
        last = out.shape[0] - 1
        for i in range(last + 1):
            for r in range(count):
                for c in range(count):
                    if i > 0:
                        out[i, r, c] += factor * work.lower[i - 1, r, c]
                    out[i, r, count + c] += factor * work.diagonal[i, r, c]
                    if i < last:
                        out[i, r, 2 * count + c] += factor * work.upper[i, r, c]

    @kernel
    def evaluate(
        parameters: Any,
        rod: Rod,
        work: Any,
        constrained: Array,
        state: State,
        u: Array,
        v: Array,
        a: Array,
        residual: Array,
        tangents: Array,
    ) -> None:
        """Fill `residual`, shape (n + 1, count), and `tangents`, shape (3, n + 1, count, 3 count): mass, damping,
        stiffness; rows and columns of constrained unknowns are without meaning. `v` is changed and restored.
        """
        tangents[:] = 0.0
        number = 0.0
        long2, short2 = LONG * LONG, SHORT * SHORT
        whole = long2 - short2
        for pair in range(2):
            size = SHORT if pair == 0 else LONG
            for sign in range(2):
                h2 = size if sign == 0 else -size
                for _ in range(2):  # friction: the second has the converged dual variable
                    set_instant(state, u, v, a, h2)
                    begin(work)
                    build(parameters, rod, work, constrained, state, 0.0, h2, number == 0.0, number)
                    number += 1.0
                if pair == 0 and sign == 0:
                    for i in range(residual.shape[0]):
                        for k in range(count):
                            residual[i, k] = right(work, i, k)
                odd = 0.5 if sign == 0 else -0.5  # of T(h): M / h + h K, at both sizes
                if pair == 0:
                    add_blocks(work, tangents[MASS], odd * SHORT * long2 / whole)
                    add_blocks(work, tangents[STIFFNESS], -odd * SHORT / whole)
                else:
                    add_blocks(work, tangents[MASS], -odd * LONG * short2 / whole)
                    add_blocks(work, tangents[STIFFNESS], odd * LONG / whole)
                    add_blocks(work, tangents[DAMPING], 0.5)

        for c in range(count):
            speed = v[0, column(c)]
            for k in range(count):
                tangents[DAMPING, 0, k, count + c] = 0.0
            for sign in range(2):
                way = 0.5 if sign == 0 else -0.5
                v[0, column(c)] = speed + 2.0 * way * CHANGE
                for _ in range(2):
                    set_instant(state, u, v, a, LONG)
                    begin(work)
                    build(parameters, rod, work, constrained, state, 0.0, LONG, False, number)
                    number += 1.0
                for k in range(count):
                    tangents[DAMPING, 0, k, count + c] += way / CHANGE * right(work, 0, k)
            v[0, column(c)] = speed

    return evaluate
