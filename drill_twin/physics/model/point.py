# SPDX-License-Identifier: Apache-2.0
"""State of the string at a Gauss point, for effects of type `distributed_load`."""

from typing import NamedTuple


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
