# SPDX-License-Identifier: Apache-2.0
"""Residual and tangent of the midpoint equations, element by element.

Unknown is the velocity v at mid-step; the configuration there is ``u = u_n + half_step v``. With the residual
``R(v) = M (v - v_n) / half_step + forces(u, v)`` its derivative is ``M / half_step + d forces/dv + half_step d
forces/du``: effects report the last two as one matrix, so that springs and dampers look alike to the solver.

The element tangent is kept as 9 component pairs by 16 shape pairs. A point adds its 3 x 3 matrices as
``S[c, k] * (N_i N_j)``: nine scalars times rows of sixteen that depend on the mesh alone, which the compiler turns into
a few vector instructions; ordered by unknowns it took four times as long.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from drill_twin.core.arrays import Array, Triple
from drill_twin.core.compile.jit import kernel
from drill_twin.dynamics.solver.interface import Effects
from drill_twin.dynamics.solver.spatial.linear_solver import Workspace
from drill_twin.physics.model import Point, Rod, strain_at, stretch_forces, stretching
from drill_twin.physics.model.section import BEND_DAMP, TORQUE_RATE, elastic_resultants, section_forces

Four = tuple[float, float, float, float]

NEAR, FAR = 5.0 / 12.0, 1.0 / 12.0  # polar inertia: mean of consistent and lumped, fourth order in the wave number


@kernel
def blend(weights: Array, nodal: Array) -> Triple:
    """Weighted sum of four nodal triples: r, r' or r'' at a point of the element."""
    w0, w1, w2, w3 = weights[0], weights[1], weights[2], weights[3]
    return (
        w0 * nodal[0, 0] + w1 * nodal[1, 0] + w2 * nodal[2, 0] + w3 * nodal[3, 0],
        w0 * nodal[0, 1] + w1 * nodal[1, 1] + w2 * nodal[2, 1] + w3 * nodal[3, 1],
        w0 * nodal[0, 2] + w1 * nodal[1, 2] + w2 * nodal[2, 2] + w3 * nodal[3, 2],
    )


@kernel
def gather(scratch: Workspace, e: int, u: Array, v: Array, v_old: Array) -> None:
    """Gather the unknowns of element e."""
    for c in range(3):
        scratch.ue[0, c], scratch.ue[1, c] = u[e, c], u[e, 3 + c]
        scratch.ue[2, c], scratch.ue[3, c] = u[e + 1, c], u[e + 1, 3 + c]
        scratch.ve[0, c], scratch.ve[1, c] = v[e, c], v[e, 3 + c]
        scratch.ve[2, c], scratch.ve[3, c] = v[e + 1, c], v[e + 1, 3 + c]
        scratch.dv[0, c], scratch.dv[1, c] = v[e, c] - v_old[e, c], v[e, 3 + c] - v_old[e, 3 + c]
        scratch.dv[2, c], scratch.dv[3, c] = v[e + 1, c] - v_old[e + 1, c], v[e + 1, 3 + c] - v_old[e + 1, 3 + c]


@kernel
def add_inertia(rod: Rod, scratch: Workspace, e: int, rate: float) -> None:
    """Set the element's tangent to its mass over half the step, its residual to its change of momentum."""
    mass, ke = rod.mass[e], scratch.ke
    ke[:] = 0.0
    for x in range(16):
        weighed = rate * mass[x // 4, x % 4]
        ke[0, x] = weighed
        ke[4, x] = weighed
        ke[8, x] = weighed
    for c in range(3):
        for i in range(4):
            total = 0.0
            for j in range(4):
                total += mass[i, j] * scratch.dv[j, c]
            scratch.re[c, i] = rate * total
    scratch.kc[:] = 0.0


@kernel
def plus(z: Four, s: float, row: Array, x: int) -> Four:
    """Four neighbours plus a multiple of four of a row: one vector instruction, if nothing is stored in between."""
    return z[0] + s * row[x], z[1] + s * row[x + 1], z[2] + s * row[x + 2], z[3] + s * row[x + 3]


@kernel
def add_stretch_at_node(rod: Rod, scratch: Workspace, e: int, end: int) -> None:
    """Add the axial force sampled at an end of the element, whose r' is itself an unknown."""
    weight = rod.samples[e, end]
    shape = 1 + 2 * end
    for c in range(3):
        scratch.re[c, shape] += weight * scratch.force[c]
        for k in range(3):
            scratch.ke[3 * c + k, 5 * shape] += weight * scratch.saa[c, k]


@kernel
def add_stretch_inside(rod: Rod, scratch: Workspace, e: int) -> None:
    """Add the axial force of the inner sample."""
    weight = rod.samples[e, 2]
    slopes, pairs, ke = rod.inner[e], rod.inner_pairs[e], scratch.ke
    for c in range(3):
        for i in range(4):
            scratch.re[c, i] += weight * slopes[i] * scratch.force[c]
        for k in range(3):
            m, s = 3 * c + k, scratch.saa[c, k]
            for x in range(0, 16, 4):
                z = (ke[m, x], ke[m, x + 1], ke[m, x + 2], ke[m, x + 3])
                ke[m, x], ke[m, x + 1], ke[m, x + 2], ke[m, x + 3] = plus(z, s, pairs, x)


@kernel
def add_point(rod: Rod, scratch: Workspace, e: int, point: int) -> None:
    """Add section and loads sampled at a Gauss point."""
    h = rod.length[e]
    weight = 0.5 * h
    shape, pairs = rod.shape[e, point], rod.pairs[e, point]
    rr, aa, ab, ba, bb = pairs[0], pairs[1], pairs[2], pairs[3], pairs[4]
    ke, kc, force, load = scratch.ke, scratch.kc, scratch.force, scratch.load
    l0, l1 = rod.spin_shape[point, 0], rod.spin_shape[point, 1]
    for c in range(3):
        fr, fa, fb = weight * load[c], weight * force[c], weight * force[3 + c]
        ca, cb = weight * scratch.coupling[0, c] / h, weight * scratch.coupling[1, c] / h
        da, db = weight * scratch.coupling[2, c], weight * scratch.coupling[3, c]
        column, row = weight * scratch.stiff[c, 3], weight * scratch.stiff[3, c]
        for i in range(4):
            n_i, d_i, c_i = shape[0, i], shape[1, i], shape[2, i]
            scratch.re[c, i] += d_i * fa + c_i * fb - n_i * fr
            slope = d_i * ca + c_i * cb
            itself = d_i * da + c_i * db
            kc[0, c, i] += l0 * (itself + n_i * column) - slope
            kc[1, c, i] += l1 * (itself + n_i * column) + slope
            kc[2, c, i] += l0 * (itself + n_i * row) - slope
            kc[3, c, i] += l1 * (itself + n_i * row) + slope
        for k in range(3):
            m = 3 * c + k
            s0, s1, s2, s3, s4 = (
                scratch.stiff[c, k],
                scratch.saa[c, k],
                scratch.sab[c, k],
                scratch.sba[c, k],
                scratch.sbb[c, k],
            )
            for x in range(0, 16, 4):
                z = (ke[m, x], ke[m, x + 1], ke[m, x + 2], ke[m, x + 3])
                z = plus(plus(plus(plus(plus(z, s0, rr, x), s1, aa, x), s2, ab, x), s3, ba, x), s4, bb, x)
                ke[m, x], ke[m, x + 1], ke[m, x + 2], ke[m, x + 3] = z


@kernel
def scatter(scratch: Workspace, e: int) -> None:
    """Add the element's matrices to the block system (all but the spin's own entries)."""
    top, bottom, low, up = scratch.diagonal[e], scratch.diagonal[e + 1], scratch.lower[e], scratch.upper[e]
    ke, kc, re = scratch.ke, scratch.kc, scratch.re
    for i in range(2):
        for c in range(3):
            row = 3 * i + c
            for j in range(2):
                for k in range(3):
                    col, m = 3 * j + k, 3 * c + k
                    top[row, col] += ke[m, 4 * i + j]
                    up[row, col] = ke[m, 4 * i + j + 2]
                    low[row, col] = ke[m, 4 * i + j + 8]
                    bottom[row, col] += ke[m, 4 * i + j + 10]
            top[row, 6] += kc[0, c, i]
            up[row, 6] = kc[1, c, i]
            low[row, 6] = kc[0, c, i + 2]
            bottom[row, 6] += kc[1, c, i + 2]
            top[6, row] += kc[2, c, i]
            up[6, row] = kc[2, c, i + 2]
            low[6, row] = kc[3, c, i]
            bottom[6, row] += kc[3, c, i + 2]
            top[row, 7] += re[c, i]
            bottom[row, 7] += re[c, i + 2]


def bind(effects: Effects) -> Callable[..., None]:
    """The assembly for a set of effects."""
    axial_damping = effects.axial_damping
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
    ) -> None:
        """Fill the block system with tangent and residual of every element; arguments as in the lateral form."""
        scratch.diagonal[:] = 0.0
        rate = 1.0 / half_step
        for e in range(rod.length.shape[0]):
            h, axial = rod.length[e], rod.axial[e]
            gather(scratch, e, u, v, v_old)
            add_inertia(rod, scratch, e, rate)
            for end in range(2):
                a = (u[e + end, 3], u[e + end, 4], u[e + end, 5])
                da = (v[e + end, 3], v[e + end, 4], v[e + end, 5])
                strain = stretching(a, da, half_step)
                viscous = axial_damping(parameters, e, axial, strain.rate)
                stretch_forces(axial, viscous[0], viscous[1], a, strain, half_step, scratch.force, scratch.saa)
                add_stretch_at_node(rod, scratch, e, end)
            a, da = blend(rod.inner[e], scratch.ue), blend(rod.inner[e], scratch.ve)
            strain = stretching(a, da, half_step)
            viscous = axial_damping(parameters, e, axial, strain.rate)
            stretch_forces(axial, viscous[0], viscous[1], a, strain, half_step, scratch.force, scratch.saa)
            add_stretch_inside(rod, scratch, e)
            own = rod.spin_mass[e] * rate
            dw0, dw1 = v[e, 6] - v_old[e, 6], v[e + 1, 6] - v_old[e + 1, 6]
            k00, k01, k10, k11 = own * NEAR, own * FAR, own * FAR, own * NEAR
            r0, r1 = k00 * dw0 + k01 * dw1, k10 * dw0 + k11 * dw1
            for point in range(2):
                shape = rod.shape[e, point]
                l0, l1 = rod.spin_shape[point, 0], rod.spin_shape[point, 1]
                psi = l0 * u[e, 6] + l1 * u[e + 1, 6]
                cos_psi, sin_psi = np.cos(psi), np.sin(psi)
                psi_rate = l0 * v[e, 6] + l1 * v[e + 1, 6]
                a, b = blend(shape[1], scratch.ue), blend(shape[2], scratch.ue)
                da, db = blend(shape[1], scratch.ve), blend(shape[2], scratch.ve)
                place = 2 * e + point
                s = strain_at(
                    e, place, a, b, da, db, psi, cos_psi, sin_psi,
                    (u[e + 1, 6] - u[e, 6]) / h, psi_rate, (v[e + 1, 6] - v[e, 6]) / h,
                )  # fmt: skip
                elastic_resultants(rod.bending[e], rod.torsion[e], s, half_step, scratch.resultants)
                section_stress(parameters, rod, s, half_step, scratch.resultants)
                section_forces(
                    rod.bending[e], s, (a[0], a[1]), (b[0], b[1]), half_step, scratch.resultants,
                    scratch.force, scratch.saa, scratch.sab, scratch.sba, scratch.sbb, scratch.coupling,
                )  # fmt: skip
                r, dr, ddr = blend(shape[0], scratch.ue), blend(shape[0], scratch.ve), blend(shape[0], scratch.dv)
                scratch.load[:] = 0.0
                scratch.stiff[:] = 0.0
                here = Point(
                    e, place, time, r[0], r[1], r[2], dr[0], dr[1], dr[2], rate * ddr[0], rate * ddr[1], rate * ddr[2],
                    s.tx, s.ty, s.tz, psi, psi_rate, rate * (l0 * dw0 + l1 * dw1), cos_psi, sin_psi, first_iteration,
                    number,
                )  # fmt: skip
                distributed_load(parameters, rod, here, half_step, scratch.load, scratch.stiff)
                # a couple about t also works on r', since the material turns at psi_dot + A(t, t_dot)
                scratch.force[0] -= scratch.load[3] * a[1] / s.fold
                scratch.force[1] += scratch.load[3] * a[0] / s.fold
                add_point(rod, scratch, e, point)
                weight = 0.5 * h
                slope = weight * scratch.resultants[TORQUE_RATE] / (h * h)
                damp = scratch.resultants[BEND_DAMP] * (s.px * s.px + s.py * s.py + s.pz * s.pz)
                itself = weight * (damp + scratch.stiff[3, 3])
                k00 += slope + l0 * l0 * itself
                k01 += l0 * l1 * itself - slope
                k10 += l0 * l1 * itself - slope
                k11 += slope + l1 * l1 * itself
                torque, couple = weight * scratch.force[6] / h, weight * (scratch.force[7] - scratch.load[3])
                r0 += l0 * couple - torque
                r1 += l1 * couple + torque
            scatter(scratch, e)
            scratch.diagonal[e, 6, 6] += k00
            scratch.upper[e, 6, 6] = k01
            scratch.lower[e, 6, 6] = k10
            scratch.diagonal[e + 1, 6, 6] += k11
            scratch.diagonal[e, 6, 7] += r0
            scratch.diagonal[e + 1, 6, 7] += r1

    return assemble
