# SPDX-License-Identifier: Apache-2.0
"""Discrete model of string and hole, from which effects compute their parameters."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drill_twin.core.arrays import Array, Integers
from drill_twin.physics.model.mesh import Rod, gauss_places
from drill_twin.physics.model.wellbore import Axis, Wellbore


class DiscreteModel(NamedTuple):
    """Meshed string and the hole around it (made by `drill_twin.dynamics.discretisation.discretise`)."""

    rod: Rod
    hole_radius: float  # outside the intervals of another radius [m]
    inclination: float  # of the hole's axis at the top clamp from vertical; the low side is +x [rad]
    wellbore: Wellbore  # the hole at the Gauss points
    contact_radius: Array  # radius in contact with the wall, blades included [m], shape (2 n,)
    section: NDArray[np.int64]  # number of the scene's section that each element belongs to, shape (n,)
    seed: int  # of the scene's random numbers
    bit_frame: Array  # of the hole at the bit (drill_twin.dynamics.solver.boundary)
    yield_strength: tuple[float | None, ...]  # of the scene's sections, where known [Pa]
    bow: Any  # block of the effect `bow`, if the scene lists it
    fluid_density: float = 0.0  # of the mud around the string [kg/m3]; 0 = none
    fluid_inside: bool = True  # whether the pipe is filled with it
    joint_area: Array | float = 0.0  # area of upsets and tool joints spread along the pipe [m2], shape (n,)
    bodies: Any = None  # the discs of the string (drill_twin.physics.effects.discs.Bodies); None: none
    fluid: Any = None  # block of the effect `mud`, if the scene lists it
    fastest_rotation: float = 0.0  # of the set-points [rad/s]
    nodes: Axis | None = None  # the hole at the nodes, where the string has discs or supports in a curved one

    def nodes_at(self, distance: Array) -> Integers:
        """Numbers of the nodes nearest to distances from the bit [m], shape (p,)."""
        return np.asarray(np.abs(self.rod.arc - distance[:, None]).argmin(axis=1), np.int64)

    @property
    def shares(self) -> Array:
        """Length of string that each node stands for, half of the elements beside it [m], shape (n + 1,)."""
        return np.asarray(0.5 * (np.append(self.rod.length, 0.0) + np.append(0.0, self.rod.length)))

    @property
    def directions(self) -> Array:
        """Direction of the hole at the nodes, shape (n + 1, 3)."""
        return np.tile([0.0, 0.0, 1.0], (self.rod.arc.size, 1)) if self.nodes is None else self.nodes.tangent

    @property
    def centres(self) -> Array:
        """Axis of the hole at the nodes [m], shape (n + 1, 3)."""
        along = self.rod.arc - self.rod.arc[-1]
        return along[:, None] * self.directions if self.nodes is None else self.nodes.centre

    @property
    def places(self) -> Array:
        """Arc length of the Gauss points from the bit [m], shape (2 n,)."""
        return places(self.rod)

    def at_places(self, per_element: Array) -> Array:
        """Values per element repeated for both Gauss points, shape (2 n,)."""
        return np.repeat(per_element, 2)

    @property
    def string_length(self) -> float:
        """Length of the string [m]."""
        return float(self.rod.arc[-1])


def places(rod: Rod) -> Array:
    """Arc length of the Gauss points from the bit [m], shape (2 n,)."""
    return (rod.arc[:-1, None] + rod.length[:, None] * gauss_places()).ravel()
