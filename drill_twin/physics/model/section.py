# SPDX-License-Identifier: Apache-2.0
"""Stress resultants of the cross-section, to which effects add, and their nodal forces and tangent.

Symbols as in `drill_twin.physics.model.strain`.
"""

from typing import NamedTuple

from drill_twin.core.arrays import Array, Pair, Triple
from drill_twin.core.compile.jit import kernel
from drill_twin.physics.model.strain import Strain

# Indices into the array of stress resultants, to which effects add (`section_stress`).
MX, MY, MZ = 0, 1, 2  # bending moment as a vector normal to t, conjugate to q [N m]
TORQUE = 3  # [N m]
COUPLE = 4  # couple on the spin per length [N]
BEND_DAMP = 5  # EI eta [N m2 s]
TORQUE_RATE = 6  # d TORQUE / d tau, both elastic (times half_step) and viscous [N m2 s]
RESULTANTS = 7


@kernel
def elastic_resultants(bending: float, torsion: float, s: Strain, half_step: float, out: Array) -> None:
    """Set the resultants by the elastic law: M = EI q, TORQUE = GJ tau."""
    out[MX], out[MY], out[MZ] = bending * s.qx, bending * s.qy, bending * s.qz
    out[TORQUE] = torsion * s.tau
    out[COUPLE] = 0.0
    out[BEND_DAMP] = 0.0
    out[TORQUE_RATE] = torsion * half_step


class Column(NamedTuple):
    """Component of the vectors in the tangent and of their combinations."""

    t: float
    p: float
    m: float
    alpha: float  # gradient of the reference twist by a
    beta: float  # by b
    on_t: float
    on_q: float
    on_m: float
    on_p: float
    mixed: float


@kernel
def tangent_entry(
    i: int, j: int, q_i: float, row: Column, col: Column, c: Triple, saa: Array, sab: Array, sba: Array, sbb: Array
) -> None:
    """Set the entries (i, j) of the four matrices; c holds torque rate, geometric and skew factors."""
    rate, geo, skew = c
    saa[i, j] = row.t * col.on_t + q_i * col.on_q + row.m * col.on_m + row.p * col.on_p + row.alpha * rate * col.alpha
    sab[i, j] = row.t * (col.mixed + skew * col.p) - geo * row.m * col.t + row.alpha * rate * col.beta
    sba[i, j] = col.t * (row.mixed - skew * row.p) - geo * row.t * col.m + row.beta * rate * col.alpha
    sbb[i, j] = rate * row.beta * col.beta


@kernel
def section_forces(
    bending: float,
    s: Strain,
    curl_a: Pair,
    curl_b: Pair,
    half_step: float,
    out: Array,
    force: Array,
    saa: Array,
    sab: Array,
    sba: Array,
    sbb: Array,
    coupling: Array,
) -> None:
    """Forces conjugate to a, b, psi', psi and their derivatives by the velocities (elastic parts times half_step).

    With Q = dq/d(a, b) the forces are Q^T m and their derivative is EI Q^T Q plus dQ^T m (written out below), to which
    internal damping adds EI eta Q^T Q and, as the material rotates against the shape,
    -half_step EI eta omega Q^T [t x] Q.

    Args:
        bending: EI [N m2].
        s: Strain.
        curl_a: (a_x, a_y).
        curl_b: (b_x, b_y).
        half_step: Half the time step [s].
        out: Resultants, shape (7,).
        force: Result, shape (8,): a, b, psi', psi.
        saa: Result, shape (3, 3): d force_a / d a_dot; `sab`, `sba`, `sbb` likewise.
        sab: Result.
        sba: Result.
        sbb: Result.
        coupling: Result, shape (4, 3): d force_a / d psi'_dot, d force_b / d psi'_dot, d force_a / d psi_dot,
            d force_b / d psi_dot (each equal to its transpose).
    """
    g, beta, tx, ty, tz = s.g, s.beta, s.tx, s.ty, s.tz
    qx, qy, qz, px, py, pz = s.qx, s.qy, s.qz, s.px, s.py, s.pz
    mx, my, mz = out[MX], out[MY], out[MZ]
    torque, couple, damp, rate = out[TORQUE], out[COUPLE], out[BEND_DAMP], out[TORQUE_RATE]
    gi = 1.0 / g
    gi2 = gi * gi
    bg = beta * gi
    qm = qx * mx + qy * my + qz * mz
    qq = qx * qx + qy * qy + qz * qz
    # gradient of A = -curl / fold by a and b; d fold / d a = (2 g + a_z) t + g e_z
    di = 1.0 / s.fold
    curl = (curl_a[0] * curl_b[1] - curl_a[1] * curl_b[0]) * di * di
    grow = curl * g * (2.0 + tz)
    ax, ay, az = grow * tx - curl_b[1] * di, grow * ty + curl_b[0] * di, grow * tz + curl * g
    bx, by = curl_a[1] * di, -curl_a[0] * di
    # a couple about t also acts on a, since omega = psi_dot + A(t, t_dot)
    force[0] = torque * ax - (bg * mx + tx * qm * gi) - couple * bx
    force[1] = torque * ay - (bg * my + ty * qm * gi) - couple * by
    force[2] = torque * az - (bg * mz + tz * qm * gi)
    force[3] = mx * gi + torque * bx
    force[4] = my * gi + torque * by
    force[5] = mz * gi
    force[6] = torque
    force[7] = -couple
    mat = (bending * half_step + damp) * gi2
    geo = half_step * gi2
    skew = -half_step * damp * s.omega * gi2
    eye = mat * bg * bg - geo * qm
    tt = mat * qq - eye + 2.0 * geo * qm
    tq, tm, tp, mg = mat * bg, 2.0 * geo * bg, skew * bg, mat * bg
    x = Column(tx, px, mx, ax, bx, tt * tx + tq * qx + tm * mx - tp * px, tq * tx + mat * qx - geo * mx,
               tm * tx - geo * qx, tp * tx, mg * tx - mat * qx - geo * mx)  # fmt: skip
    y = Column(ty, py, my, ay, by, tt * ty + tq * qy + tm * my - tp * py, tq * ty + mat * qy - geo * my,
               tm * ty - geo * qy, tp * ty, mg * ty - mat * qy - geo * my)  # fmt: skip
    z = Column(tz, pz, mz, az, 0.0, tt * tz + tq * qz + tm * mz - tp * pz, tq * tz + mat * qz - geo * mz,
               tm * tz - geo * qz, tp * tz, mg * tz - mat * qz - geo * mz)  # fmt: skip
    c = (rate, geo, skew)
    tangent_entry(0, 0, qx, x, x, c, saa, sab, sba, sbb)
    tangent_entry(0, 1, qx, x, y, c, saa, sab, sba, sbb)
    tangent_entry(0, 2, qx, x, z, c, saa, sab, sba, sbb)
    tangent_entry(1, 0, qy, y, x, c, saa, sab, sba, sbb)
    tangent_entry(1, 1, qy, y, y, c, saa, sab, sba, sbb)
    tangent_entry(1, 2, qy, y, z, c, saa, sab, sba, sbb)
    tangent_entry(2, 0, qz, z, x, c, saa, sab, sba, sbb)
    tangent_entry(2, 1, qz, z, y, c, saa, sab, sba, sbb)
    tangent_entry(2, 2, qz, z, z, c, saa, sab, sba, sbb)
    for i in range(3):
        saa[i, i] += eye
        sab[i, i] -= mg
        sba[i, i] -= mg
        sbb[i, i] += mat
    # -mat t t^T and skew [t x] in sbb; the leading second derivative of A in sab and sba
    sbb[0, 0] -= mat * tx * tx
    sbb[1, 1] -= mat * ty * ty
    sbb[2, 2] -= mat * tz * tz
    sbb[0, 1] -= mat * tx * ty + skew * tz
    sbb[1, 0] -= mat * tx * ty - skew * tz
    sbb[0, 2] -= mat * tx * tz - skew * ty
    sbb[2, 0] -= mat * tx * tz + skew * ty
    sbb[1, 2] -= mat * ty * tz + skew * tx
    sbb[2, 1] -= mat * ty * tz - skew * tx
    twist = half_step * torque * di
    sab[0, 1] -= twist
    sab[1, 0] += twist
    sba[1, 0] -= twist
    sba[0, 1] += twist
    # coupling to the spin: torsion through psi', internal damping through psi_dot (-EI eta Q^T p)
    coupling[0, 0], coupling[0, 1], coupling[0, 2] = rate * ax, rate * ay, rate * az
    coupling[1, 0], coupling[1, 1], coupling[1, 2] = rate * bx, rate * by, 0.0
    da, db = damp * beta * gi2, -damp * gi
    coupling[2, 0], coupling[2, 1], coupling[2, 2] = da * px, da * py, da * pz
    coupling[3, 0], coupling[3, 1], coupling[3, 2] = db * px, db * py, db * pz
