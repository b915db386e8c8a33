# SPDX-License-Identifier: Apache-2.0
"""Stretch of the rod: axial force and its tangent at one place.

The strain is sampled at the nodes and at mid-element and integrated by Simpson's rule. A bent cubic element cannot be
free of axial strain everywhere; asking for it at three places only, two of them shared with the neighbours, keeps it
from locking (the minimally constrained strains of Meier, Popp and Wall 2015). Two Gauss points would be too few: they
leave a stretching mode without energy.
"""

import numpy as np

from drill_twin.rod.jit import kernel
from drill_twin.rod.types import Array, Triple


@kernel
def stretch_rate(a: Triple, da: Triple) -> float:
    """Rate of the axial strain |r'| - 1 from r' and its rate [1/s]."""
    g = np.sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2])
    return float((a[0] * da[0] + a[1] * da[1] + a[2] * da[2]) / g)


@kernel
def stretch_forces(axial: float, viscous: float, slope: float, a: Triple, h2: float, force: Array, saa: Array) -> None:
    """Force conjugate to a = r' and its derivative by the velocity (elastic part times h2).

    Args:
        axial: EA [N].
        viscous: Viscous axial force [N].
        slope: Its derivative by the strain rate [N s].
        a: r'.
        h2: Half the time step [s].
        force: Result, the first 3 of shape (8,).
        saa: Result, shape (3, 3).
    """
    g = np.sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2])
    gi = 1.0 / g
    tx, ty, tz = a[0] * gi, a[1] * gi, a[2] * gi
    tension = axial * (g - 1.0) + viscous
    across = h2 * tension * gi
    along = axial * h2 + slope - across
    force[0], force[1], force[2] = tension * tx, tension * ty, tension * tz
    saa[0, 0], saa[1, 1], saa[2, 2] = along * tx * tx + across, along * ty * ty + across, along * tz * tz + across
    saa[0, 1] = saa[1, 0] = along * tx * ty
    saa[0, 2] = saa[2, 0] = along * tx * tz
    saa[1, 2] = saa[2, 1] = along * ty * tz
