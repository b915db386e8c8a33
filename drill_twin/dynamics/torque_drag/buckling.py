# SPDX-License-Identifier: Apache-2.0
"""Buckling of pipe in a hole: the compression at which it snakes and at which it forms a helix.

* Sinusoidal: F_s = 2 sqrt(EI w / r), w the force per length that presses the pipe to the wall, r the radial clearance
  (Dawson and Paslay 1984; with w of a curved hole: He and Kyllingstad 1995, Mitchell 1999). In a vertical hole, where w
  is zero, 1.94 (EI q^2)^(1/3) with the weight per length q (Lubinski 1950).
* Helical: sqrt(2) F_s (Chen, Lin and Cheatham 1990); 5.55 (EI q^2)^(1/3) in a vertical hole (Wu, Juvkam-Wold and Lu
  1993). Between sqrt(2) and 2 sqrt(2) F_s both shapes are possible, above it only the helix (Mitchell 1997).
"""

from __future__ import annotations

import math
from enum import IntEnum
from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array

CHEN, MITCHELL = np.sqrt(2.0), 2.0 * np.sqrt(2.0)
"""Helical load over the sinusoidal one: the least at which a helix persists, and from which it is the only shape."""
LUBINSKI, WU = 1.94, 5.55
"""Factors of (EI q^2)^(1/3) in a vertical hole: sinusoidal and helical."""


class BucklingState(IntEnum):
    """Shape of the pipe under its compression."""

    STRAIGHT = 0
    SINUSOIDAL = 1
    SINUSOIDAL_OR_HELICAL = 2
    HELICAL = 3

    @property
    def label(self) -> str:
        """Name in tables."""
        return self.name.lower().replace("_", " ")


class BucklingLoads(NamedTuple):
    """Compression of buckling along the string, shape (n,) each."""

    sinusoidal: Array
    """[N]."""
    helical: Array
    """Least load of the helix [N]."""

    def states(self, tension: Array) -> Array:
        """`BucklingState` of each element under an effective tension [N]."""
        share = np.maximum(-tension, 0.0) / np.maximum(self.sinusoidal, 1e-300)
        upper = np.maximum(-tension, 0.0) / np.maximum(self.helical, 1e-300)
        steps = (share > 1.0).astype(int) + (upper > 1.0) + (upper > MITCHELL / CHEN)
        return np.asarray(steps)

    def margins(self, tension: Array) -> tuple[float, float]:
        """Least of sinusoidal and of helical load over the compression; infinite where nothing is compressed."""
        squeezed = tension < 0.0
        if not squeezed.any():
            return math.inf, math.inf
        sinusoidal, helical = (float((load[squeezed] / -tension[squeezed]).min()) for load in self)
        return sinusoidal, helical


def buckling_loads(bending: Array, pressing: Array, weight: Array, clearance: Array) -> BucklingLoads:
    """Compression at which pipe buckles.

    Args:
        bending: EI [N m2].
        pressing: Force per length that presses the unbuckled pipe to the wall, w [N/m].
        weight: Buoyant weight per length, q [N/m].
        clearance: Radial clearance r [m].
    """
    snaking = 2.0 * np.sqrt(bending * pressing / clearance)
    vertical = np.cbrt(bending * weight**2)
    return BucklingLoads(np.maximum(snaking, LUBINSKI * vertical), np.maximum(CHEN * snaking, WU * vertical))
