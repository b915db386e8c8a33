# SPDX-License-Identifier: Apache-2.0
"""Strains of the shear-free rod at one point (all but stretch), and the resultants that effects may add to.

Symbols (Meier, Popp and Wall 2014; the twist is written for a vertical-ish string, see below):

* ``a = r'``, ``b = r''`` by arc length; ``g = |a|``, tangent ``t = a / g``;
* ``q = t' = (b - t (t.b)) / g`` the bending strain as a vector normal to t, ``p = t x q``;
* ``tau = psi' + A``, twist. The material frame is the smallest rotation that takes z to t, then the spin psi about t;
  the twist of that reference is ``A = -(a_x b_y - a_y b_x) / (g (g + a_z))``, an explicit function of the
  configuration, so that nothing drifts over thousands of turns. It is singular only where t = -z, a string folded
  back on itself by half a turn;
* ``omega = psi_dot + A(t, t_dot)``, the material's angular velocity about t;
* ``ring = P q_dot - omega p``, the rate of q seen by the turning material: what internal damping resists.
"""

from typing import NamedTuple

import numpy as np

from drill_twin.base.arrays import Array, Pair, Triple
from drill_twin.base.jit import kernel

# Places in the array of stress resultants; effects of the section add to them.
MX, MY, MZ = 0, 1, 2  # bending moment as a vector normal to t, conjugate to q [N m]
TORQUE = 3  # [N m]
COUPLE = 4  # couple on the spin per length [N]
BEND_DAMP = 5  # EI eta [N m2 s]
TORQUE_RATE = 6  # d TORQUE / d tau, both elastic (times h2) and viscous [N m2 s]
RESULTANTS = 7


class Strain(NamedTuple):
    """Kinematics of the section at a Gauss point; the fields are scalars so that the compiler keeps only those used."""

    element: int
    place: int  # number of the Gauss point along the string, 2 element + (0 or 1)
    g: float
    tx: float
    ty: float
    tz: float
    beta: float  # t . b
    qx: float
    qy: float
    qz: float
    px: float
    py: float
    pz: float
    fold: float  # g (g + a_z), the denominator of A
    tau: float
    tau_rate: float
    omega: float
    ring_x: float
    ring_y: float
    ring_z: float
    psi: float
    cos_psi: float
    sin_psi: float


@kernel
def strain_at(
    element: int,
    place: int,
    a: Triple,
    b: Triple,
    da: Triple,
    db: Triple,
    psi: float,
    cos_psi: float,
    sin_psi: float,
    psi_arc: float,
    psi_rate: float,
    psi_arc_rate: float,
) -> Strain:
    """Strains and strain rates from a, b and their rates (triples) and the spin, its slope and their rates."""
    ax, ay, az = a
    bx, by, bz = b
    dax, day, daz = da
    dbx, dby, dbz = db
    g = np.sqrt(ax * ax + ay * ay + az * az)
    gi = 1.0 / g
    tx, ty, tz = ax * gi, ay * gi, az * gi
    beta = tx * bx + ty * by + tz * bz
    qx, qy, qz = (bx - tx * beta) * gi, (by - ty * beta) * gi, (bz - tz * beta) * gi
    px, py, pz = ty * qz - tz * qy, tz * qx - tx * qz, tx * qy - ty * qx
    fold = max(g * (g + az), 1e-12)
    curl = ax * by - ay * bx
    tau = psi_arc - curl / fold
    # rates
    g_rate = tx * dax + ty * day + tz * daz
    fold_rate = 2.0 * g * g_rate + g_rate * az + g * daz
    curl_rate = dax * by + ax * dby - day * bx - ay * dbx
    tau_rate = psi_arc_rate - curl_rate / fold + curl * fold_rate / (fold * fold)
    omega = psi_rate - (ax * day - ay * dax) / fold
    # P q_dot: q = (b - t beta)/g, so P q_dot = (P b_dot - beta t_dot)/g - q g_rate/g with t_dot = P a_dot / g
    tdx, tdy, tdz = (dax - tx * g_rate) * gi, (day - ty * g_rate) * gi, (daz - tz * g_rate) * gi
    tb = tx * dbx + ty * dby + tz * dbz
    rx = ((dbx - tx * tb) - beta * tdx - qx * g_rate) * gi - omega * px
    ry = ((dby - ty * tb) - beta * tdy - qy * g_rate) * gi - omega * py
    rz = ((dbz - tz * tb) - beta * tdz - qz * g_rate) * gi - omega * pz
    return Strain(
        element, place, g, tx, ty, tz, beta, qx, qy, qz, px, py, pz, fold, tau, tau_rate, omega,
        rx, ry, rz, psi, cos_psi, sin_psi,
    )  # fmt: skip


@kernel
def elastic_resultants(bending: float, torsion: float, s: Strain, h2: float, out: Array) -> None:
    """Start the resultants with the elastic law: M = EI q, TORQUE = GJ tau."""
    out[MX], out[MY], out[MZ] = bending * s.qx, bending * s.qy, bending * s.qz
    out[TORQUE] = torsion * s.tau
    out[COUPLE] = 0.0
    out[BEND_DAMP] = 0.0
    out[TORQUE_RATE] = torsion * h2


class Column(NamedTuple):
    """One component of the vectors that the tangent is made of, and of their combinations."""

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
    """Entries (i, j) of the four matrices; c holds torque rate, geometric and skew factors."""
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
    h2: float,
    out: Array,
    force: Array,
    saa: Array,
    sab: Array,
    sba: Array,
    sbb: Array,
    coupling: Array,
) -> None:
    """Forces conjugate to a, b, psi', psi and their derivatives by the velocities (times 1; elastic parts times h2).

    With Q = dq/d(a, b) the forces are Q^T m and their derivative is EI Q^T Q plus dQ^T m (written out below), to which
    internal damping adds EI eta Q^T Q and, as the material turns under the shape, -h2 EI eta omega Q^T [t x] Q.

    Args:
        bending: EI [N m2].
        s: Strain.
        curl_a: (a_x, a_y).
        curl_b: (b_x, b_y).
        h2: Half the time step [s].
        out: Resultants, shape (7,).
        force: Result, shape (8,): a, b, psi', psi.
        saa: Result, shape (3, 3): d force_a / d a_dot; `sab`, `sba`, `sbb` likewise.
        sab: Result.
        sba: Result.
        sbb: Result.
        coupling: Result, shape (4, 3): d force_a / d psi'_dot, d force_b / d psi'_dot, d force_a / d psi_dot,
            d force_b / d psi_dot (each equal to its mirror).
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
    # a couple about t also works on a, since omega = psi_dot + A(t, t_dot)
    force[0] = torque * ax - (bg * mx + tx * qm * gi) - couple * bx
    force[1] = torque * ay - (bg * my + ty * qm * gi) - couple * by
    force[2] = torque * az - (bg * mz + tz * qm * gi)
    force[3] = mx * gi + torque * bx
    force[4] = my * gi + torque * by
    force[5] = mz * gi
    force[6] = torque
    force[7] = -couple
    mat = (bending * h2 + damp) * gi2
    geo = h2 * gi2
    skew = -h2 * damp * s.omega * gi2
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
    twist = h2 * torque * di
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
