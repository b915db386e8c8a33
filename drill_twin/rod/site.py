# SPDX-License-Identifier: Apache-2.0
"""Where the string hangs: what effects need to know beside the rod to turn their scene block into numbers."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drill_twin.rod.mesh import Rod
from drill_twin.rod.shape import gauss_places


class Site(NamedTuple):
    """The meshed string and the hole around it."""

    rod: Rod
    hole_radius: float  # [m]
    inclination: float  # of the hole axis from vertical; the low side is +x [rad]
    fluid_density: float = 0.0  # of the mud around the string [kg/m3]; 0 = none

    @property
    def places(self) -> NDArray[np.float64]:
        """Arc length of the Gauss points from the bit [m], shape (2 n,)."""
        rod = self.rod
        return (rod.arc[:-1, None] + rod.length[:, None] * gauss_places()).ravel()

    def at_places(self, per_element: NDArray[np.float64]) -> NDArray[np.float64]:
        """Repeat a value per element for its two Gauss points, shape (2 n,)."""
        return np.repeat(per_element, 2)

    @property
    def string_length(self) -> float:
        """Length of the string [m]."""
        return float(self.rod.arc[-1])
