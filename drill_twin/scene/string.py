# SPDX-License-Identifier: Apache-2.0
"""The string: tube sections from the bit up, and the marks watched on it."""

import math
from collections.abc import Iterator
from typing import Annotated, Literal, NamedTuple, Self

from pydantic import Field, model_validator

from drill_twin.scene.part import Part, refuse_at
from drill_twin.units import Density, Dimensionless, Length, Pressure, Within

Name = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_]*$", max_length=60)]
"""A name that can be part of a joint's name on a topic."""

LONGEST_STRING = 20_000.0
"""Longest string [m]; the longest wells reach 15 km."""

MOST_JOINTS = 2000
"""Most tool joints of a section; each costs an element or two."""

BitEnd = Literal["guided", "pinned", "sliding", "free", "stabilised"]


class Piece(NamedTuple):
    """A uniform stretch of the string: a section, or the pipe or a tool joint of one."""

    length: float
    """Length [m]."""
    outer_diameter: float
    """Outer diameter of the body [m]."""
    contact_diameter: float
    """Diameter that meets the wall, blades included [m]."""
    section: "Section"
    """Section it belongs to; it has its bore and material."""


class Joints(Part):
    """Tool joints along a section: short lengths of larger outer diameter; bore and material are the section's."""

    spacing: Annotated[Length, Within(above="0 m", at_most="1 km")]
    """From joint to joint [m]; going up, each such length of the section ends in a joint."""
    length: Annotated[Length, Within(above="0 m", at_most="10 m")]
    """Length of a joint [m]."""
    diameter: Annotated[Length, Within(above="0 m", at_most="5 m")]
    """Outer diameter of a joint [m]; it stiffens, weighs and meets the wall."""


class Section(Part):
    """A length of tube or rod, uniform but for its tool joints."""

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
    blade_diameter: Annotated[Length, Within(above="0 m", at_most="5 m")] | None = None
    """Diameter over the blades of a stabiliser [m]: it meets the wall and carries wall marks, but neither stiffens nor
    weighs. Left out: the outer diameter."""
    joints: Joints | None = None
    """Tool joints, if any."""

    @model_validator(mode="after")
    def _is_a_tube(self) -> Self:
        if self.inner_diameter >= self.outer_diameter:
            raise refuse_at(
                ("inner_diameter",),
                f"expected less than the outer diameter ({self.outer_diameter:.6g} m), "
                f"found {self.inner_diameter:.6g} m",
            )
        return self

    @model_validator(mode="after")
    def _blades_stand_out(self) -> Self:
        if self.blade_diameter is not None and self.blade_diameter < self.outer_diameter:
            raise refuse_at(
                ("blade_diameter",),
                f"expected at least the outer diameter ({self.outer_diameter:.6g} m), "
                f"found {self.blade_diameter:.6g} m",
            )
        return self

    @model_validator(mode="after")
    def _joints_fit(self) -> Self:
        joints = self.joints
        if joints is None:
            return self
        if joints.diameter < self.outer_diameter:
            raise refuse_at(
                ("joints", "diameter"),
                f"expected at least the outer diameter ({self.outer_diameter:.6g} m), found {joints.diameter:.6g} m",
            )
        if joints.length >= joints.spacing:
            raise refuse_at(
                ("joints", "length"),
                f"expected less than the spacing ({joints.spacing:.6g} m), found {joints.length:.6g} m",
            )
        if not 1.0 <= self.length / joints.spacing <= MOST_JOINTS:
            raise refuse_at(
                ("joints", "spacing"),
                f"expected between 1 and {MOST_JOINTS} joints in the section ({self.length:.6g} m long), "
                f"found {joints.spacing:.6g} m",
            )
        return self

    @property
    def contact_diameter(self) -> float:
        """Diameter that meets the wall between joints, blades included [m]."""
        return self.blade_diameter or self.outer_diameter

    def pieces(self) -> Iterator[Piece]:
        """The uniform pieces from the bit up."""
        rest = self.length
        if self.joints is not None:
            pipe = self.joints.spacing - self.joints.length
            meets = max(self.joints.diameter, self.contact_diameter)
            for _ in range(int(self.length / self.joints.spacing * (1.0 + 1e-12))):
                yield Piece(pipe, self.outer_diameter, self.contact_diameter, self)
                yield Piece(self.joints.length, self.joints.diameter, meets, self)
                rest -= self.joints.spacing
        if rest > 1e-9 * self.length:
            yield Piece(rest, self.outer_diameter, self.contact_diameter, self)

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
    """`wall`: on the outer surface (on a blade where there are blades), it carries the spin; `centre`: on the centre
    line."""


class String(Part):
    """The drillstring, from the bit (arc length 0) to the clamp at the top."""

    sections: Annotated[tuple[Section, ...], Field(min_length=1, max_length=1000)]
    """Sections FROM THE BIT UP."""
    marks: Annotated[tuple[Mark, ...], Field(max_length=100)] = ()
    """Marks, in any order."""
    bit_end: BitEnd = "sliding"
    """`guided`: on the axis, no tilt, slides axially and spins; `pinned`: on the axis, free tilt; `sliding`: free
    sideways, no tilt; `free`: no constraint; `stabilised`: as `free`, within what `effects.bit_stabiliser` allows."""

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
        return self._piece_at(distance_from_bit).section

    def radius_at(self, distance_from_bit: float) -> float:
        """Radius of the surface that meets the wall [m], blades and tool joints included, as for `section_at`."""
        return 0.5 * self._piece_at(distance_from_bit).contact_diameter

    @property
    def pieces(self) -> tuple[Piece, ...]:
        """The uniform pieces from the bit up, tool joints on their own."""
        return tuple(piece for section in self.sections for piece in section.pieces())

    def _piece_at(self, distance_from_bit: float) -> Piece:
        bottom = 0.0
        for piece in self.pieces:
            bottom += piece.length
            if distance_from_bit < bottom:
                return piece
        return self.pieces[-1]
