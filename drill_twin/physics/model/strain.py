# SPDX-License-Identifier: Apache-2.0
"""Strains of the shear-free rod at one point: bending, twist and stretch; the state there that effects are given.

Symbols (Meier, Popp and Wall 2014, except for the twist):

* ``a = r'``, ``b = r''`` by arc length; ``g = |a|``, tangent ``t = a / g``;
* ``q = t' = (b - t (t.b)) / g``, the bending strain as a vector normal to t, ``p = t x q``;
* ``tau = psi' + A``, twist. The material frame is the smallest rotation that takes z to t, then the spin psi about t;
  the twist of that reference is ``A = -(a_x b_y - a_y b_x) / (g (g + a_z))``, an explicit function of the
  configuration, so that nothing drifts over thousands of revolutions. It is singular only where t = -z, in a string
  folded back on itself by half a turn;
* ``omega = psi_dot + A(t, t_dot)``, the angular velocity of the material about t;
* ``ring = P q_dot - omega p``, the rate of q in the rotating material frame, on which internal damping acts.

Stretch is sampled at the nodes and at mid-element and integrated by Simpson's rule. A bent cubic element cannot be
free of axial strain everywhere; three sampling points, two of them shared with the neighbours, avoid locking (the
minimally constrained strains of Meier, Popp and Wall 2015). Two Gauss points would leave a stretching mode without
energy. In the two elements at a change of section, where the strain jumps, the node between them has little weight
(`drill_twin.physics.model.mesh.stretch_samples`). The axial force is the mean of the forces at both ends of the step,
along the chord between the ends, which conserves the energy of stretch exactly (Simo and Tarnow 1992, Zeitschrift fuer
angewandte Mathematik und Physik 43). With the force at mid-step, fast axial waves coupled to lateral motion could gain
energy from the error.
"""

from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array, Triple
from drill_twin.core.compile.jit import kernel


class Strain(NamedTuple):
    """Kinematics of the section at a Gauss point; scalar fields, so that the compiler drops unused fields."""

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


class Point(NamedTuple):
    """State of the string at a Gauss point; SI units, vectors in the frame `hole`."""

    element: int
    place: int  # number of the Gauss point along the string, 2 element + (0 or 1)
    time: float
    x: float
    y: float
    z: float
    vx: float
    vy: float
    vz: float
    ax: float  # acceleration; in the tangent, a mass per length m adds m / half_step
    ay: float
    az: float
    tx: float
    ty: float
    tz: float
    spin: float
    spin_rate: float
    spin_up: float  # its acceleration; in the tangent, an inertia per length j adds j / half_step
    cos_spin: float  # computed once for all effects
    sin_spin: float
    first_iteration: bool  # first Newton iteration of a step
    iteration: float  # number of this Newton iteration in the run


@kernel
def rotate_to_tangent(tx: float, ty: float, tz: float, x: float, y: float) -> Triple:
    """Rotate a direction (x, y, 0) by the smallest rotation that takes z to the unit vector t."""
    across = x * tx + y * ty
    share = across / (1.0 + tz)
    return x - tx * share, y - ty * share, -across


def transverse_axes(tangent: Array) -> tuple[Array, Array]:
    """Axes x and y of the frame `hole`, turned by the smallest rotation of z onto the tangent; shape (..., 3) each."""
    x, y, z = tangent[..., 0], tangent[..., 1], tangent[..., 2]
    fold = 1.0 + z
    return (
        np.stack((1.0 - x * x / fold, -x * y / fold, -x), axis=-1),
        np.stack((-x * y / fold, 1.0 - y * y / fold, -y), axis=-1),
    )


@kernel
def along_element(weights: Array, rows: Array, e: int) -> Triple:
    """Weighted sum of r and r' of both nodes of an element, from node rows: r, r' or r'' at a point of it."""
    w, below, above = weights, rows[e], rows[e + 1]
    return (
        w[0] * below[0] + w[1] * below[3] + w[2] * above[0] + w[3] * above[3],
        w[0] * below[1] + w[1] * below[4] + w[2] * above[1] + w[3] * above[4],
        w[0] * below[2] + w[1] * below[5] + w[2] * above[2] + w[3] * above[5],
    )


class Stretching(NamedTuple):
    """Strain |r'| - 1 over a step."""

    mean: float  # of its values at both ends [-]
    rate: float  # [1/s]
    chord: float  # 2 / (|r'| before + |r'| after): times r' at mid-step it is the strain's gradient between the ends
    tx: float  # direction of r' at the end of the step
    ty: float
    tz: float


@kernel
def stretching(a: Triple, da: Triple, half_step: float) -> Stretching:
    """Axial strain over a step from r' at its middle, the rate of r' [1/s], and half the step [s]."""
    wx, wy, wz = half_step * da[0], half_step * da[1], half_step * da[2]
    bx, by, bz = a[0] + wx, a[1] + wy, a[2] + wz
    cx, cy, cz = a[0] - wx, a[1] - wy, a[2] - wz
    after, before = np.sqrt(bx * bx + by * by + bz * bz), np.sqrt(cx * cx + cy * cy + cz * cz)
    chord = 2.0 / (before + after)
    rate = chord * (a[0] * da[0] + a[1] * da[1] + a[2] * da[2])
    return Stretching(1.0 / chord - 1.0, rate, chord, bx / after, by / after, bz / after)


@kernel
def stretch_forces(
    axial: float, viscous: float, slope: float, a: Triple, s: Stretching, half_step: float, force: Array, saa: Array
) -> None:
    """Compute the force conjugate to a = r' and its derivative by the velocity (elastic part times half_step).

    Args:
        axial: EA [N].
        viscous: Viscous axial force [N].
        slope: Its derivative by the strain rate [N s].
        a: r' at mid-step.
        s: Its stretching.
        half_step: Half the time step [s].
        force: Result, the first 3 of shape (8,).
        saa: Result, shape (3, 3).
    """
    tension = axial * s.mean + viscous
    itself = half_step * tension * s.chord
    along = (axial * half_step + slope - itself) * s.chord
    for c in range(3):
        force[c] = tension * s.chord * a[c]
        saa[c, 0], saa[c, 1], saa[c, 2] = along * a[c] * s.tx, along * a[c] * s.ty, along * a[c] * s.tz
        saa[c, c] += itself
