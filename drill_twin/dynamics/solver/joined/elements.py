# SPDX-License-Identifier: Apache-2.0
"""Elements above the joint: residual and tangent of a string that follows the hole.

Unknown are the coordinate z along the hole (minus the measured depth), z' by arc length, and the spin psi. Shape
functions, samples of stretch and inertia are as for the string in space. The tangent is the hole's tangent, so the
strain is z' - 1 and the twist psi' less the psi' of the untwisted string. Across the hole the forces are in balance:
the loads of the effects there, and the tension times the curvature, press the string to the wall (Johancsik and others
1984). Friction follows from the force on the wall.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.compile.jit import kernel
from drill_twin.dynamics.solver.interface import Effects
from drill_twin.dynamics.solver.joined.linear_solver import Workspace
from drill_twin.dynamics.solver.spatial.assembly import FAR, NEAR
from drill_twin.physics.model import Axis, Point, Rod, Strain
from drill_twin.physics.model.section import BEND_DAMP, COUPLE, TORQUE, TORQUE_RATE, elastic_resultants

Z0, SLOPE0, Z1, SLOPE1, SPIN0, SPIN1 = range(6)


class Along(NamedTuple):
    """Direction of the hole at a coordinate, and its curvature towards the normal."""

    tx: float
    ty: float
    tz: float
    nx: float
    ny: float
    nz: float
    curvature: float  # [1/m]


@kernel
def along(axis: Axis | None, place: int, z: float) -> Along:
    """The hole of a point of the string where it has come to the coordinate z [m]."""
    if axis is None:
        return Along(0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0)
    t, n, k = axis.tangent[place], axis.normal[place], axis.curvature[place]
    angle = k * (z - axis.along[place])
    square = angle * angle
    # of the small angle by which the string has moved along the hole, to 1e-9 at 0.1 rad
    cos, sin = 1.0 - square * (0.5 - square / 24.0), angle * (1.0 - square * (1.0 / 6.0 - square / 120.0))
    return Along(
        cos * t[0] + sin * n[0], cos * t[1] + sin * n[1], cos * t[2] + sin * n[2],
        cos * n[0] - sin * t[0], cos * n[1] - sin * t[1], cos * n[2] - sin * t[2], k,
    )  # fmt: skip


@kernel
def dot(stiff: Array, left: Along, right: Along) -> float:
    """Part of a tangent along the hole."""
    x = stiff[0, 0] * right.tx + stiff[0, 1] * right.ty + stiff[0, 2] * right.tz
    y = stiff[1, 0] * right.tx + stiff[1, 1] * right.ty + stiff[1, 2] * right.tz
    z = stiff[2, 0] * right.tx + stiff[2, 1] * right.ty + stiff[2, 2] * right.tz
    return float(left.tx * x + left.ty * y + left.tz * z)


@kernel
def add_stretch(
    scratch: Workspace, slopes: tuple[float, float, float, float], weight: float, force: float, slope: float
) -> None:
    """Add the axial force at a sample whose strain is a sum of the four unknowns."""
    for i in range(4):
        scratch.forces[i] += weight * slopes[i] * force
        for k in range(4):
            scratch.element[i, k] += weight * slope * slopes[i] * slopes[k]


@kernel
def scatter(scratch: Workspace, j: int) -> None:
    """Add an element's matrices to the system."""
    ke, top, bottom = scratch.element, scratch.diagonal[j], scratch.diagonal[j + 1]
    for i in range(3):
        row = SPIN0 if i == 2 else i
        other = SPIN1 if i == 2 else i + 2
        scratch.right[j, i] += scratch.forces[row]
        scratch.right[j + 1, i] += scratch.forces[other]
        for k in range(3):
            col = SPIN0 if k == 2 else k
            far = SPIN1 if k == 2 else k + 2
            top[i, k] += ke[row, col]
            scratch.upper[j, i, k] = ke[row, far]
            scratch.lower[j, i, k] = ke[other, col]
            bottom[i, k] += ke[other, far]


def bind(effects: Effects, section_stress: Any, distributed_load: Any, friction: Any) -> Callable[..., None]:
    """The assembly for a set of effects, and for their functions that a string along the hole needs."""
    axial_damping = effects.axial_damping

    @kernel
    def assemble(
        parameters: Any, rod: Rod, scratch: Workspace, time: float, half_step: float, first_iteration: bool,
        number: float,
    ) -> None:  # fmt: skip
        """Fill the system above the joint; arguments as in the spatial form."""
        scratch.diagonal[:] = 0.0
        scratch.right[:] = 0.0
        rate, first = 1.0 / half_step, scratch.rod.length.shape[0]
        ke, re, work = scratch.element, scratch.forces, scratch.below
        for j in range(scratch.twist.shape[0]):
            e = first + j
            h, axial, mass = rod.length[e], rod.axial[e], rod.mass[e]
            q, dq, old = scratch.here, scratch.rate, scratch.old
            z0, s0, z1, s1 = q[j, 0], q[j, 1], q[j + 1, 0], q[j + 1, 1]
            dz0, ds0, dz1, ds1 = dq[j, 0], dq[j, 1], dq[j + 1, 0], dq[j + 1, 1]
            a0, a1, a2, a3 = dz0 - old[j, 0], ds0 - old[j, 1], dz1 - old[j + 1, 0], ds1 - old[j + 1, 1]
            ke[:] = 0.0
            for i in range(4):
                for k in range(4):
                    ke[i, k] = rate * mass[i, k]
                re[i] = rate * (mass[i, 0] * a0 + mass[i, 1] * a1 + mass[i, 2] * a2 + mass[i, 3] * a3)
            viscous = axial_damping(parameters, e, axial, ds0)
            add_stretch(scratch, (0.0, 1.0, 0.0, 0.0), rod.samples[e, 0], axial * (s0 - 1.0) + viscous[0],
                        axial * half_step + viscous[1])  # fmt: skip
            viscous = axial_damping(parameters, e, axial, ds1)
            add_stretch(scratch, (0.0, 0.0, 0.0, 1.0), rod.samples[e, 1], axial * (s1 - 1.0) + viscous[0],
                        axial * half_step + viscous[1])  # fmt: skip
            w = rod.inner[e]
            viscous = axial_damping(parameters, e, axial, w[0] * dz0 + w[1] * ds0 + w[2] * dz1 + w[3] * ds1)
            strain = w[0] * z0 + w[1] * s0 + w[2] * z1 + w[3] * s1 - 1.0
            add_stretch(scratch, (w[0], w[1], w[2], w[3]), rod.samples[e, 2], axial * strain + viscous[0],
                        axial * half_step + viscous[1])  # fmt: skip
            own = rod.spin_mass[e] * rate
            dw0, dw1 = dq[j, 2] - old[j, 2], dq[j + 1, 2] - old[j + 1, 2]
            ke[4, 4], ke[4, 5], ke[5, 4], ke[5, 5] = own * NEAR, own * FAR, own * FAR, own * NEAR
            re[4], re[5] = own * (NEAR * dw0 + FAR * dw1), own * (FAR * dw0 + NEAR * dw1)
            twist, twist_rate = (q[j + 1, 2] - q[j, 2]) / h - scratch.twist[j], (dq[j + 1, 2] - dq[j, 2]) / h
            for point in range(2):
                n, d = rod.shape[e, point, 0], rod.shape[e, point, 1]
                l0, l1 = rod.spin_shape[point, 0], rod.spin_shape[point, 1]
                z = n[0] * z0 + n[1] * s0 + n[2] * z1 + n[3] * s1
                speed = n[0] * dz0 + n[1] * ds0 + n[2] * dz1 + n[3] * ds1
                growth = rate * (n[0] * a0 + n[1] * a1 + n[2] * a2 + n[3] * a3)
                strain = d[0] * z0 + d[1] * s0 + d[2] * z1 + d[3] * s1 - 1.0
                at = along(scratch.points, 2 * j + point, z)
                psi, psi_rate = l0 * q[j, 2] + l1 * q[j + 1, 2], l0 * dq[j, 2] + l1 * dq[j + 1, 2]
                cos, sin = np.cos(psi), np.sin(psi)
                bend = at.curvature
                qx, qy, qz = bend * at.nx, bend * at.ny, bend * at.nz
                px, py, pz = at.ty * qz - at.tz * qy, at.tz * qx - at.tx * qz, at.tx * qy - at.ty * qx
                s = Strain(
                    e, 2 * e + point, 1.0, at.tx, at.ty, at.tz, 0.0, qx, qy, qz, px, py, pz, 1.0 + at.tz, twist,
                    twist_rate, psi_rate, -psi_rate * px, -psi_rate * py, -psi_rate * pz, psi, cos, sin,
                )  # fmt: skip
                elastic_resultants(rod.bending[e], rod.torsion[e], s, half_step, work.resultants)
                section_stress(parameters, rod, s, half_step, work.resultants)
                work.load[:] = 0.0
                work.stiff[:] = 0.0
                here = Point(
                    e, 2 * e + point, time, 0.0, 0.0, z, speed * at.tx, speed * at.ty, speed * at.tz,
                    growth * at.tx, growth * at.ty, growth * at.tz, at.tx, at.ty, at.tz,
                    psi, psi_rate, rate * (l0 * dw0 + l1 * dw1), cos, sin, first_iteration, number,
                )  # fmt: skip
                distributed_load(parameters, rod, here, half_step, work.load, work.stiff)
                weight, load, stiff, pull = 0.5 * h, work.load, work.stiff, axial * strain * bend
                on = load[0] * at.tx + load[1] * at.ty + load[2] * at.tz
                wx, wy, wz = (
                    load[0] - on * at.tx + pull * at.nx,
                    load[1] - on * at.ty + pull * at.ny,
                    load[2] - on * at.tz + pull * at.nz,
                )
                across = np.sqrt(wx * wx + wy * wy + wz * wz)
                side, rub, couple, k_zz, k_zs, k_ss = friction(parameters, here, speed, across)
                scratch.side[2 * j + point] = side
                # friction follows the tension, by the part of the load across that does
                share = half_step * axial * bend * (wx * at.nx + wy * at.ny + wz * at.nz) / max(across * across, 1e-300)
                k_zz += dot(stiff, at, at)
                to_z = k_zs + stiff[3, 0] * at.tx + stiff[3, 1] * at.ty + stiff[3, 2] * at.tz
                to_spin = k_zs + stiff[0, 3] * at.tx + stiff[1, 3] * at.ty + stiff[2, 3] * at.tz
                for i in range(4):
                    re[i] -= weight * n[i] * (on + rub)
                    for c in range(4):
                        ke[i, c] += weight * n[i] * (k_zz * n[c] - share * rub * d[c])
                    ke[i, 4] += weight * to_spin * n[i] * l0
                    ke[i, 5] += weight * to_spin * n[i] * l1
                    ke[4, i] += weight * l0 * (to_z * n[i] - share * couple * d[i])
                    ke[5, i] += weight * l1 * (to_z * n[i] - share * couple * d[i])
                slope = weight * work.resultants[TORQUE_RATE] / (h * h)
                itself = weight * (work.resultants[BEND_DAMP] * bend * bend + stiff[3, 3] + k_ss)
                torque = weight * work.resultants[TORQUE] / h
                couple = -weight * (work.resultants[COUPLE] + load[3] + couple)
                ke[4, 4] += slope + l0 * l0 * itself
                ke[4, 5] += l0 * l1 * itself - slope
                ke[5, 4] += l0 * l1 * itself - slope
                ke[5, 5] += slope + l1 * l1 * itself
                re[4] += l0 * couple - torque
                re[5] += l1 * couple + torque
            scatter(scratch, j)

    return assemble
