# SPDX-License-Identifier: Apache-2.0
"""Where the string hangs: what effects need to know beside the rod to turn their scene block into numbers."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drill_twin.base.arrays import Array
from drill_twin.model.mesh import Rod
from drill_twin.model.shape_functions import gauss_places
from drill_twin.model.wellbore import Bore


class DiscreteModel(NamedTuple):
    """The meshed string and the hole around it (built by `drill_twin.discretisation.discretise`)."""

    rod: Rod
    hole_radius: float  # outside the intervals of another radius [m]
    inclination: float  # of the hole's axis at the top clamp from vertical; the low side is +x [rad]
    bore: Bore  # the hole as the Gauss points meet it
    contact_radius: Array  # of the surface that meets the wall, blades included [m], shape (2 n,)
    section: NDArray[np.int64]  # number of the scene's section that each element belongs to, shape (n,)
    seed: int  # of everything random in the scene
    fluid_density: float = 0.0  # of the mud around the string [kg/m3]; 0 = none
    fluid_viscosity: float = 0.0  # [Pa s]
    fluid_inside: bool = True  # whether the string's bore is full of it

    @property
    def places(self) -> Array:
        """Arc length of the Gauss points from the bit [m], shape (2 n,)."""
        return places(self.rod)

    def at_places(self, per_element: Array) -> Array:
        """Repeat a value per element for its two Gauss points, shape (2 n,)."""
        return np.repeat(per_element, 2)

    @property
    def string_length(self) -> float:
        """Length of the string [m]."""
        return float(self.rod.arc[-1])


def places(rod: Rod) -> Array:
    """Arc length of the Gauss points from the bit [m], shape (2 n,)."""
    return (rod.arc[:-1, None] + rod.length[:, None] * gauss_places()).ravel()
