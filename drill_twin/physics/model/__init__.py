# SPDX-License-Identifier: Apache-2.0
"""The rod: mesh, state layout, kinematics of a point, the elastic section; here is what other rooms use most of it."""

from drill_twin.physics.model.discrete_model import DiscreteModel, places
from drill_twin.physics.model.mesh import (
    SPIN,
    Rod,
    Tube,
    build_rod,
    element_unknowns,
    elements_per_section,
    locate,
    part_of,
    rod_of,
    tube_constants,
    youngs_modulus,
)
from drill_twin.physics.model.strain import (
    Point,
    Strain,
    along_element,
    rotate_to_tangent,
    strain_at,
    stretch_forces,
    stretching,
    transverse_axes,
)
from drill_twin.physics.model.wellbore import Axis, Wellbore, axis_offset, distance_along, offsets

__all__ = [
    "SPIN",
    "Axis",
    "DiscreteModel",
    "Point",
    "Rod",
    "Strain",
    "Tube",
    "Wellbore",
    "along_element",
    "axis_offset",
    "build_rod",
    "distance_along",
    "element_unknowns",
    "elements_per_section",
    "locate",
    "offsets",
    "part_of",
    "places",
    "rod_of",
    "rotate_to_tangent",
    "strain_at",
    "stretch_forces",
    "stretching",
    "transverse_axes",
    "tube_constants",
    "youngs_modulus",
]
