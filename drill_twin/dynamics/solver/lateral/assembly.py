# SPDX-License-Identifier: Apache-2.0
"""Residual and tangent of a string that neither stretches nor twists: small slopes, two lateral components.

Bending is linear, ``EI r''``; the axial force N(s) is in balance at every instant and acts through the slope,
``N r'``; the spin is the top drive's everywhere. The effects are the same functions as in space and see a straight
tangent.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from drill_twin.core.arrays import Array, Pair
from drill_twin.core.compile.jit import kernel
from drill_twin.dynamics.solver.interface import Effects
from drill_twin.dynamics.solver.lateral.linear_solver import TORQUE, WEIGHT, Workspace
from drill_twin.physics.model import Point, Rod, Strain
from drill_twin.physics.model.section import BEND_DAMP, COUPLE, MX, MY


@kernel
def blend(weights: Array, nodal: Array) -> Pair:
    """Weighted sum of four nodal pairs."""
    w0, w1, w2, w3 = weights[0], weights[1], weights[2], weights[3]
    return (
        w0 * nodal[0, 0] + w1 * nodal[0, 1] + w2 * nodal[0, 2] + w3 * nodal[0, 3],
        w0 * nodal[1, 0] + w1 * nodal[1, 1] + w2 * nodal[1, 2] + w3 * nodal[1, 3],
    )


@kernel
def gather(scratch: Workspace, e: int, u: Array, v: Array, v_old: Array) -> None:
    """Gather the unknowns of element e."""
    for k in range(4):
        node, first = e + k // 2, 3 * (k % 2)
        for c in range(2):
            scratch.ue[c, k], scratch.ve[c, k] = u[node, first + c], v[node, first + c]
            scratch.dv[c, k] = v[node, first + c] - v_old[node, first + c]


@kernel
def start_tangent(rod: Rod, scratch: Workspace, e: int, rate: float) -> None:
    """Set the element's tangent to its mass over half the step."""
    mass, ke = rod.mass[e], scratch.ke
    ke[:] = 0.0
    for x in range(16):
        ke[0, x] = ke[3, x] = rate * mass[x // 4, x % 4]


@kernel
def start_residual(rod: Rod, scratch: Workspace, e: int, rate: float) -> None:
    """Set the element's residual to its change of momentum."""
    mass = rod.mass[e]
    for c in range(2):
        for i in range(4):
            row = mass[i]
            total = (
                row[0] * scratch.dv[c, 0]
                + row[1] * scratch.dv[c, 1]
                + row[2] * scratch.dv[c, 2]
                + row[3] * scratch.dv[c, 3]
            )
            scratch.re[c, i] = rate * total


@kernel
def add_tangent(
    rod: Rod, scratch: Workspace, e: int, point: int, tension: float, half_step: float, spin_rate: float
) -> None:
    """Add the stiffness and damping of section and loads at a Gauss point."""
    pairs, ke = rod.pairs[e, point], scratch.ke
    damp = scratch.resultants[BEND_DAMP]
    bend, turn, string = rod.bending[e] * half_step + damp, damp * half_step * spin_rate, tension * half_step
    s0, s1, s2, s3 = scratch.stiff[0, 0], scratch.stiff[0, 1], scratch.stiff[1, 0], scratch.stiff[1, 1]
    for x in range(16):
        rr, aa, bb = pairs[0, x], pairs[1, x], pairs[4, x]
        same = string * aa + bend * bb
        ke[0, x] += same + s0 * rr
        ke[1, x] += turn * bb + s1 * rr
        ke[2, x] += s2 * rr - turn * bb
        ke[3, x] += same + s3 * rr


@kernel
def add_residual(rod: Rod, scratch: Workspace, e: int, point: int, tension: float, a: Pair) -> None:
    """Add the forces of section and loads at a Gauss point."""
    weight = 0.5 * rod.length[e]
    shape, load, out = rod.shape[e, point], scratch.load, scratch.resultants
    for c in range(2):
        pull, moment, push = weight * tension * a[c], weight * out[MX + c], weight * load[c]
        couple = weight * scratch.stiff[3, c]
        for i in range(4):
            scratch.lever[e + i // 2, 2 * (i % 2) + c] += couple * shape[0, i]
            scratch.re[c, i] += shape[1, i] * pull + shape[2, i] * moment - shape[0, i] * push


@kernel
def scatter_residual(scratch: Workspace, e: int) -> None:
    """Add the element's residual to the block system."""
    for i in range(2):
        for c in range(2):
            scratch.right[e, 2 * i + c] += scratch.re[c, i]
            scratch.right[e + 1, 2 * i + c] = scratch.re[c, i + 2]


@kernel
def scatter_tangent(scratch: Workspace, e: int) -> None:
    """Add the element's tangent to the block system."""
    top, bottom, low, up = scratch.diagonal[e], scratch.diagonal[e + 1], scratch.lower[e], scratch.upper[e]
    ke = scratch.ke
    for i in range(2):
        for c in range(2):
            row = 2 * i + c
            for j in range(2):
                for k in range(2):
                    col, m = 2 * j + k, 2 * c + k
                    top[row, col] += ke[m, 4 * i + j]
                    up[row, col] = ke[m, 4 * i + j + 2]
                    low[row, col] = ke[m, 4 * i + j + 8]
                    bottom[row, col] = ke[m, 4 * i + j + 10]


def bind(effects: Effects) -> Callable[..., float]:
    """The assembly for a set of effects."""
    section_stress, distributed_load = effects.section_stress, effects.distributed_load

    @kernel
    def assemble(
        parameters: Any,
        rod: Rod,
        scratch: Workspace,
        time: float,
        half_step: float,
        first_iteration: bool,
        number: float,
        u: Array,
        v: Array,
        v_old: Array,
        tension: float,
        full: bool,
    ) -> float:
        """Fill the block system with the residual of every element, and with its tangent if `full`.

        Args:
            parameters: Of the effects.
            rod: The string.
            scratch: Holds the result.
            time: At mid-step [s].
            half_step: Half the step [s].
            first_iteration: First iteration of a step.
            number: Number of the iteration in the run.
            u: Rows at mid-step, shape (n + 1, 7).
            v: Velocities at mid-step.
            v_old: Velocities at the start of the step.
            tension: Axial force in the string at the bit [N], negative under weight on bit.
            full: Assemble the tangent too.

        Returns:
            Stiffness and damping that the effects add along the string, summed: where it changes, the factors of an
            older tangent cannot be used [N s/m].
        """
        rate = 1.0 / half_step
        n = rod.length.shape[0]
        psi, spin_rate = u[n, 6], v[n, 6]
        spin_up = rate * (spin_rate - v_old[n, 6])
        cos_psi, sin_psi = np.cos(psi), np.sin(psi)
        along, torque, added = 0.0, 0.0, 0.0
        if full:
            scratch.diagonal[0, :, :] = 0.0
        scratch.right[0, :] = 0.0
        scratch.lever[:] = 0.0
        for e in range(n):
            h = rod.length[e]
            gather(scratch, e, u, v, v_old)
            start_residual(rod, scratch, e, rate)
            if full:
                start_tangent(rod, scratch, e, rate)
            if e < scratch.nodes.shape[0]:
                along -= scratch.nodes[e, 2, 7]
                torque += scratch.nodes[e, 6, 7]
            below = along
            for point in range(2):
                shape = rod.shape[e, point]
                place, share = 2 * e + point, rod.spin_shape[point, 1]
                b, db = blend(shape[2], scratch.ue), blend(shape[2], scratch.ve)
                # material at spin psi: the rate of r'' that it sees (`drill_twin.physics.model.section`, t = z)
                ring_x, ring_y = db[0] + spin_rate * b[1], db[1] - spin_rate * b[0]
                strain = Strain(
                    e, place, 1.0, 0.0, 0.0, 1.0, 0.0, b[0], b[1], 0.0, -b[1], b[0], 0.0, 2.0, 0.0, 0.0, spin_rate,
                    ring_x, ring_y, 0.0, psi, cos_psi, sin_psi,
                )  # fmt: skip
                out = scratch.resultants
                out[:] = 0.0
                out[MX], out[MY] = rod.bending[e] * b[0], rod.bending[e] * b[1]
                section_stress(parameters, rod, strain, half_step, out)
                r, dr, ddr = blend(shape[0], scratch.ue), blend(shape[0], scratch.ve), blend(shape[0], scratch.dv)
                scratch.load[:] = 0.0
                scratch.stiff[:] = 0.0
                here = Point(
                    e, place, time, r[0], r[1], rod.arc[e] + share * h - rod.arc[n], dr[0], dr[1], 0.0,
                    rate * ddr[0], rate * ddr[1], 0.0, 0.0, 0.0, 1.0, psi, spin_rate, spin_up,
                    cos_psi, sin_psi, first_iteration, number,
                )  # fmt: skip
                distributed_load(parameters, rod, here, half_step, scratch.load, scratch.stiff)
                weight = 0.5 * h
                along += weight * scratch.load[2]
                added += weight * (scratch.stiff[0, 0] + scratch.stiff[1, 1])
                torque -= weight * (out[COUPLE] + scratch.load[3])
                force = tension - below - share * h * scratch.load[2]
                add_residual(rod, scratch, e, point, force, blend(shape[1], scratch.ue))
                if full:
                    add_tangent(rod, scratch, e, point, force, half_step, spin_rate)
            torque += rod.spin_mass[e] * spin_up
            scatter_residual(scratch, e)
            if full:
                scatter_tangent(scratch, e)
        if n < scratch.nodes.shape[0]:
            along -= scratch.nodes[n, 2, 7]
            torque += scratch.nodes[n, 6, 7]
        scratch.axial[WEIGHT] = along
        scratch.axial[TORQUE] = torque
        return added

    return assemble
