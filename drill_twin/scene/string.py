# SPDX-License-Identifier: Apache-2.0
"""The string: tube sections from the bit up, and the marks watched on it."""

import math
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from drill_twin.scene.part import Part, refuse_at
from drill_twin.units import Density, Dimensionless, Length, Pressure, Within

Name = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_]*$", max_length=60)]
"""A name that can be part of a joint's name on a topic."""

LONGEST_STRING = 20_000.0
"""Longest string [m]; the longest wells reach 15 km."""

BitEnd = Literal["guided", "pinned", "sliding", "free"]


class Section(Part):
    """A uniform length of tube or rod."""

    name: str = ""
    """What reports call it."""
    length: Annotated[Length, Within(above="0 m", at_most="20 km")]
    """Length [m]."""
    outer_diameter: Annotated[Length, Within(above="0 m", at_most="5 m")]
    """Outer diameter [m]."""
    inner_diameter: Annotated[Length, Within(at_least="0 m", at_most="5 m")] = 0.0
    """Inner diameter [m]; 0 m = solid."""
    youngs_modulus: Annotated[Pressure, Within(at_least="1 kPa", at_most="10000 GPa")]
    """Young's modulus E [Pa]."""
    poisson_ratio: Annotated[Dimensionless, Within(above="-1", at_most="0.5")]
    """Poisson's ratio [-]; with E it gives the shear modulus."""
    density: Annotated[Density, Within(above="0 kg/m^3", at_most="30000 kg/m^3", reason="osmium has 22600")]
    """Density of the material [kg/m^3]."""

    @model_validator(mode="after")
    def _is_a_tube(self) -> Self:
        if self.inner_diameter >= self.outer_diameter:
            raise refuse_at(
                ("inner_diameter",),
                f"expected less than the outer diameter ({self.outer_diameter:.6g} m), "
                f"found {self.inner_diameter:.6g} m",
            )
        return self

    @property
    def area(self) -> float:
        """Cross-section A [m^2]."""
        return math.pi / 4.0 * (self.outer_diameter**2 - self.inner_diameter**2)

    @property
    def second_moment(self) -> float:
        """Second moment of area I for bending [m^4]; the polar moment J is twice this."""
        return math.pi / 64.0 * (self.outer_diameter**4 - self.inner_diameter**4)

    @property
    def shear_modulus(self) -> float:
        """Shear modulus G = E / (2 (1 + nu)) [Pa]."""
        return self.youngs_modulus / (2.0 * (1.0 + self.poisson_ratio))

    @property
    def mass_per_length(self) -> float:
        """Mass per length [kg/m]."""
        return self.density * self.area


class Mark(Part):
    """A point of the string whose motion is published and analysed."""

    name: Name
    """Name on the topics: letters, digits and underscores, a letter first."""
    distance_from_bit: Annotated[Length, Within(at_least="0 m", at_most="20 km")]
    """Arc length from the bit [m]."""
    on: Literal["wall", "centre"] = "wall"
    """`wall`: on the outer wall, it carries the spin; `centre`: on the centre line."""


class String(Part):
    """The drillstring, from the bit (arc length 0) to the clamp at the top."""

    sections: Annotated[tuple[Section, ...], Field(min_length=1, max_length=1000)]
    """Sections FROM THE BIT UP."""
    marks: Annotated[tuple[Mark, ...], Field(max_length=100)] = ()
    """Marks, in any order."""
    bit_end: BitEnd = "sliding"
    """`guided`: on the axis, no tilt, slides axially and spins; `pinned`: on the axis, free tilt; `sliding`: free
    sideways, no tilt; `free`: no constraint."""

    @model_validator(mode="after")
    def _is_of_a_length_that_is_drilled(self) -> Self:
        if self.length > LONGEST_STRING:
            raise refuse_at(
                ("sections",),
                f"expected at most {LONGEST_STRING / 1000.0:g} km in all, found {self.length / 1000.0:.6g} km",
            )
        return self

    @model_validator(mode="after")
    def _marks_are_on_it(self) -> Self:
        for index, mark in enumerate(self.marks):
            if mark.distance_from_bit > self.length * (1.0 + 1e-12):
                raise refuse_at(
                    ("marks", index, "distance_from_bit"),
                    f'expected "{mark.name}" on the string ({self.length:.6g} m long), '
                    f"found {mark.distance_from_bit:.6g} m from the bit",
                )
            if mark.name in [other.name for other in self.marks[:index]]:
                raise refuse_at(("marks", index, "name"), f'expected a name of its own, found "{mark.name}" again')
        return self

    @property
    def length(self) -> float:
        """Length from bit to top clamp [m]."""
        return math.fsum(section.length for section in self.sections)

    def section_at(self, distance_from_bit: float) -> Section:
        """The section at an arc length from the bit [m]; at a joint, the upper one; beyond the ends, the end one."""
        bottom = 0.0
        for section in self.sections:
            bottom += section.length
            if distance_from_bit < bottom:
                return section
        return self.sections[-1]
