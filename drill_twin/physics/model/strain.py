# SPDX-License-Identifier: Apache-2.0
"""Bending and twist of the shear-free rod at one point; stretch is in `drill_twin.physics.model.stretch`.

Symbols (Meier, Popp and Wall 2014, except for the twist):

* ``a = r'``, ``b = r''`` by arc length; ``g = |a|``, tangent ``t = a / g``;
* ``q = t' = (b - t (t.b)) / g``, the bending strain as a vector normal to t, ``p = t x q``;
* ``tau = psi' + A``, twist. The material frame is the smallest rotation that takes z to t, then the spin psi about t;
  the twist of that reference is ``A = -(a_x b_y - a_y b_x) / (g (g + a_z))``, an explicit function of the
  configuration, so that nothing drifts over thousands of revolutions. It is singular only where t = -z, in a string
  folded back on itself by half a turn;
* ``omega = psi_dot + A(t, t_dot)``, the angular velocity of the material about t;
* ``ring = P q_dot - omega p``, the rate of q in the rotating material frame, on which internal damping acts.
"""

from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Triple
from drill_twin.core.compile.jit import kernel


class Strain(NamedTuple):
    """Kinematics of the section at a Gauss point; scalar fields, so that the compiler drops those not used."""

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
    """Strains and strain rates from a, b, the spin, its derivative by arc length, and the rates of all."""
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
