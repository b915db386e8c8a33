# SPDX-License-Identifier: Apache-2.0
"""Stretch of the rod: axial force and its tangent at one point.

The strain is sampled at the nodes and at mid-element and integrated by Simpson's rule. A bent cubic element cannot be
free of axial strain everywhere; three sampling points, two of them shared with the neighbours, avoid locking (the
minimally constrained strains of Meier, Popp and Wall 2015). Two Gauss points would leave a stretching mode without
energy. In the two elements at a change of section, where the strain jumps, the node between them has little weight
(`drill_twin.physics.model.mesh.stretch_samples`).

The force is the mean of those at both ends of the step, along the chord between them, which conserves the energy of
stretch exactly (Simo and Tarnow 1992, Zeitschrift fuer angewandte Mathematik und Physik 43). With the force at
mid-step, fast axial waves coupled to lateral motion could gain energy from the error.
"""

from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array, Triple
from drill_twin.core.compile.jit import kernel


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
