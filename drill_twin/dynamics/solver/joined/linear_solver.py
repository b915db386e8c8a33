# SPDX-License-Identifier: Apache-2.0
"""The block-tridiagonal system above the joint, three unknowns a node, and the workspace of the joined form.

The system is eliminated from the top down, which leaves a 3 x 3 system at the joint: for the string below, an end
condition. Once the string below is solved, the nodes above follow one after another.
"""

from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array, Mask
from drill_twin.core.compile.jit import kernel
from drill_twin.dynamics.solver.spatial.linear_solver import SMALLEST_PIVOT
from drill_twin.dynamics.solver.spatial.linear_solver import Workspace as Below
from drill_twin.dynamics.solver.spatial.linear_solver import make_workspace as make_below
from drill_twin.physics.model import Axis, Rod, part_of

ALONG = 3
"""Unknowns a node above the joint: coordinate along the hole z, its derivative z' by arc length, spin psi."""
KEPT = 1
"""Index into `Workspace.size`."""


class Workspace(NamedTuple):
    """The system below the joint, the system of the m elements above it, and the hole there."""

    command: Array  # (3,) set-points, the array of `below`
    below: Below
    rod: Rod  # the elements below the joint
    held: Array  # (2, 7) constrained unknowns of the bit and, none, of the joint
    nodes: Axis | None  # the hole at the joint and the nodes above, m + 1 points; None: straight
    points: Axis | None  # at the Gauss points above, 2 m points
    side: Array  # (2 m,) force that presses the Gauss points above to the wall [N/m]
    twist: Array  # (m,) psi' of the untwisted string [rad/m]
    joint: Array  # (2, 3) gradient of z by r, and of z' by r', at the joint
    start: Array  # (m + 1, 3) z [m], z', psi [rad] at the start of the step
    old: Array  # (m + 1, 3) their rates then
    here: Array  # (m + 1, 3) at mid-step
    rate: Array  # (m + 1, 3) their rates there
    diagonal: Array  # (m + 1, 3, 3)
    right: Array  # (m + 1, 3) residual
    lower: Array  # (m, 3, 3) block of node j + 1 by node j
    upper: Array  # (m, 3, 3) block of node j by node j + 1
    solved: Array  # (m, 3, 4) nodes j + 1 by node j, and their Newton step for a node j at rest
    change: Array  # (m + 1, 3) Newton step
    top: Array  # (3, 7) rows of the top before its constraints: by itself, by the node below; reaction
    element: Array  # (6, 6) tangent of an element: z_0, z'_0, z_1, z'_1, psi_0, psi_1
    forces: Array  # (6,) its residual
    size: Array  # (2,) of the last Newton step there in tolerances; 1 where the system of the iteration before is kept
    rows: Array  # (3, nodes, 7) rows at mid-step, velocities then and at the start, in space; (3, 0, 7): no loads
    loads: Array  # (nodes, 7, 8) loads on the nodes of the whole string, in space; (0, 7, 8): none


def make_workspace(
    rod: Rod, above: int, constrained: Mask, nodes: Axis | None, points: Axis | None, twist: Array, loaded: int = 0
) -> Workspace:
    """Arrays of zeros for a string whose last elements, `above` of them, follow the hole."""
    m, n = above, rod.length.size - above
    below = make_below(n)
    part = part_of(rod, 0, n)
    held = np.stack([constrained[0], np.zeros(7)])
    nodal: list[Array] = [np.zeros((m + 1, ALONG)) for _ in range(4)]
    blocks: list[Array] = [np.zeros((m, ALONG, ALONG)) for _ in range(2)]
    arrays = (np.zeros(2 * m), twist, np.zeros((2, ALONG)), *nodal, np.zeros((m + 1, ALONG, ALONG)))
    rest = (
        np.zeros((m, ALONG, ALONG + 1)),
        np.zeros((m + 1, ALONG)),
        np.zeros((ALONG, 7)),
        np.zeros((6, 6)),
        np.zeros(6),
        np.zeros(2),
    )
    right = np.zeros((m + 1, ALONG))
    loads = np.zeros((3, loaded, 7)), np.zeros((loaded, 7, 8))
    return Workspace._make((below.command, below, part, held, nodes, points, *arrays, right, *blocks, *rest, *loads))


@kernel
def eliminate_above(scratch: Workspace) -> bool:
    """Eliminate all nodes above the joint; false if a pivot vanishes."""
    for j in range(scratch.solved.shape[0] - 1, -1, -1):
        d, x = scratch.diagonal[j + 1], scratch.solved[j]
        for i in range(ALONG):
            for k in range(ALONG):
                x[i, k] = scratch.lower[j, i, k]
            x[i, ALONG] = scratch.right[j + 1, i]
        for k in range(ALONG):
            if not abs(d[k, k]) > SMALLEST_PIVOT:
                return False
            inverse = 1.0 / d[k, k]
            for i in range(k + 1, ALONG):
                factor = d[i, k] * inverse
                for c in range(k + 1, ALONG):
                    d[i, c] -= factor * d[k, c]
                for c in range(ALONG + 1):
                    x[i, c] -= factor * x[k, c]
        for k in range(ALONG - 1, -1, -1):
            inverse = 1.0 / d[k, k]
            for c in range(ALONG + 1):
                for i in range(k + 1, ALONG):
                    x[k, c] -= d[k, i] * x[i, c]
                x[k, c] *= inverse
        for i in range(ALONG):
            for k in range(ALONG):
                factor = scratch.upper[j, i, k]
                for c in range(ALONG):
                    scratch.diagonal[j, i, c] -= factor * x[k, c]
                scratch.right[j, i] -= factor * x[k, ALONG]
    return True


@kernel
def keep_above(scratch: Workspace) -> None:
    """Set what is left of an eliminated system after its Newton step: the force on the joint, which has moved."""
    for i in range(ALONG):
        for k in range(ALONG):
            scratch.right[0, i] -= scratch.diagonal[0, i, k] * scratch.change[0, k]
    scratch.solved[:, :, ALONG] = 0.0


@kernel
def add_to_joint(scratch: Workspace) -> None:
    """Add what is left at the joint to the top node of the string below."""
    last = scratch.below.diagonal.shape[0] - 1
    own, d, g = scratch.below.diagonal[last], scratch.diagonal[0], scratch.joint
    for i in range(ALONG):
        for a in range(3 if i < 2 else 1):
            row = 3 * i + a
            by_row = g[i, a] if i < 2 else 1.0
            own[row, 7] += by_row * scratch.right[0, i]
            for k in range(ALONG):
                for b in range(3 if k < 2 else 1):
                    own[row, 3 * k + b] += by_row * d[i, k] * (g[k, b] if k < 2 else 1.0)


@kernel
def solve_above(scratch: Workspace) -> None:
    """Fill in the Newton step of the nodes above from the Newton step of the joint."""
    last = scratch.below.diagonal.shape[0] - 1
    own, g, change = scratch.below.diagonal[last], scratch.joint, scratch.change
    for i in range(2):
        change[0, i] = g[i, 0] * own[3 * i, 7] + g[i, 1] * own[3 * i + 1, 7] + g[i, 2] * own[3 * i + 2, 7]
    change[0, 2] = own[6, 7]
    for j in range(scratch.solved.shape[0]):
        x = scratch.solved[j]
        for i in range(ALONG):
            total = x[i, ALONG]
            for k in range(ALONG):
                total -= x[i, k] * change[j, k]
            change[j + 1, i] = total
