# SPDX-License-Identifier: Apache-2.0
"""The `string:` part of a scene: sections from the bit up, marks, and the constraint of the bit.

A section is a tube with its material, blades and tool joints.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import accumulate
from typing import Annotated, Any, Literal, NamedTuple

from pydantic import Field

from drill_twin.core.units import Density, Dimensionless, Length, LinearMass, Pressure, Torque, Within
from drill_twin.physics.effects.config import Label, Part, Problem, repeated_names
from drill_twin.physics.effects.discs import Disc, PartName, PartPlace
from drill_twin.physics.effects.supports import Support

LONGEST_STRING = 20_000.0
"""Longest string [m]; the longest wells reach 15 km."""

BitEnd = Literal["guided", "pinned", "sliding", "free", "stabilised"]


MOST_JOINTS = 2000
"""Most tool joints of a section; each needs an element or two."""


class Piece(NamedTuple):
    """Uniform piece of the string: a section, or the pipe or a tool joint of a section."""

    length: float
    """Length [m]."""
    outer_diameter: float
    """Outer diameter of the body [m]."""
    contact_diameter: float
    """Diameter in contact with the wall, blades included [m]."""
    section: Section
    """Section of the piece, with inner diameter and material."""


class Joints(Part):
    """Tool joints of a section: short lengths of larger outer diameter; bore and material are the section's."""

    spacing: Annotated[Length, Within(above="0 m", at_most="1 km")]
    """Distance between joints [m]; the upper end of each such length of the section is a joint."""
    length: Annotated[Length, Within(above="0 m", at_most="10 m")]
    """Length of a joint [m]."""
    diameter: Annotated[Length, Within(above="0 m", at_most="5 m")]
    """Outer diameter of a joint [m], for stiffness, mass and wall contact."""


class Section(Part):
    """Section of the string: a uniform tube or rod, with or without tool joints."""

    name: Label = ""
    """Name in reports."""
    length: Annotated[Length, Within(above="0 m", at_most="20 km")]
    """Length [m]."""
    outer_diameter: Annotated[Length, Within(above="0 m", at_most="5 m")]
    """Outer diameter [m]."""
    inner_diameter: Annotated[Length, Within(at_least="0 m", at_most="5 m")] = 0.0
    """Inner diameter [m]; 0 m = solid."""
    youngs_modulus: Annotated[Pressure, Within(at_least="1 kPa", at_most="10000 GPa")] = 206.8e9
    """Young's modulus E [Pa]; left out: steel's, as in the two next keys."""
    poisson_ratio: Annotated[Dimensionless, Within(above="-1", at_most="0.5")] = 0.3
    """Poisson's ratio [-], for the shear modulus."""
    density: Annotated[Density, Within(above="0 kg/m^3", at_most="30000 kg/m^3", reason="osmium has 22600")] = 7850.0
    """Density of the material [kg/m^3]."""
    blade_diameter: Annotated[Length, Within(above="0 m", at_most="5 m")] | None = None
    """Diameter over the blades of a stabiliser [m], for wall contact and wall marks; stiffness and mass are the tube's.
    Left out: the outer diameter."""
    joints: Joints | None = None
    """Tool joints, if any."""
    adjusted_mass: Annotated[LinearMass, Within(above="0 kg/m", at_most="1e5 kg/m")] | None = None
    """Mass per length with upsets and tool joints spread over it (the adjusted weight of API RP 7G) [kg/m]; they
    displace mud too. Left out: the tube's. Not with `joints`."""
    yield_strength: Annotated[Pressure, Within(above="0 Pa", at_most="100 GPa")] | None = None
    """Yield strength of the tube, for margins [Pa]."""
    make_up_torque: Annotated[Torque, Within(above="0 N m", at_most="1e7 N m")] | None = None
    """Make-up torque of its connections, for margins [N m]."""

    def problems(self) -> Iterator[Problem]:
        """A bore, blades or tool joints that do not fit the tube, and a mass that is given twice or is too small."""
        outer, joints = f"the outer diameter ({self.outer_diameter:.6g} m)", self.joints
        if self.inner_diameter >= self.outer_diameter:
            yield ("inner_diameter",), f"expected less than {outer}, found {self.inner_diameter:.6g} m"
        if self.blade_diameter is not None and self.blade_diameter < self.outer_diameter:
            yield ("blade_diameter",), f"expected at least {outer}, found {self.blade_diameter:.6g} m"
        if joints is not None and joints.diameter < self.outer_diameter:
            yield ("joints", "diameter"), f"expected at least {outer}, found {joints.diameter:.6g} m"
        if joints is not None and joints.length >= joints.spacing:
            text = f"expected less than the spacing ({joints.spacing:.6g} m), found {joints.length:.6g} m"
            yield ("joints", "length"), text
        if joints is not None and not 1.0 <= self.length / joints.spacing <= MOST_JOINTS:
            yield (
                ("joints", "spacing"),
                (
                    f"expected between 1 and {MOST_JOINTS} joints in the section ({self.length:.6g} m long), "
                    f"found {joints.spacing:.6g} m"
                ),
            )
        if self.adjusted_mass is not None and joints is not None:
            yield ("adjusted_mass",), "expected either `joints` or `adjusted_mass`, found both"
        elif self.adjusted_mass is not None and self.adjusted_mass < (tube := self.density * self.area) * (1.0 - 1e-9):
            text = f"expected at least the tube's mass ({tube:.6g} kg/m), found {self.adjusted_mass:.6g} kg/m"
            yield ("adjusted_mass",), text

    @property
    def contact_diameter(self) -> float:
        """Diameter in contact with the wall between joints, blades included [m]."""
        return self.blade_diameter or self.outer_diameter

    def pieces(self) -> Iterator[Piece]:
        """Yield the uniform pieces from the bit up."""
        rest = self.length
        if self.joints is not None:
            pipe = self.joints.spacing - self.joints.length
            contact = max(self.joints.diameter, self.contact_diameter)
            for _ in range(int(self.length / self.joints.spacing * (1.0 + 1e-12))):
                yield Piece(pipe, self.outer_diameter, self.contact_diameter, self)
                yield Piece(self.joints.length, self.joints.diameter, contact, self)
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
        """Mass per length, upsets and tool joints of `adjusted_mass` included [kg/m]."""
        return self.density * self.area if self.adjusted_mass is None else self.adjusted_mass


class Mark(Part):
    """Point of the string at which motion is published and analysed."""

    name: PartName
    """Name on the topics: letters, digits and underscores, a letter first."""
    distance_from_bit: PartPlace
    """Arc length from the bit [m]."""
    on: Literal["wall", "centre"] = "wall"
    """`wall`: on the outer surface (on a blade, if any), rotating with the spin; `centre`: on the centre line."""


def places_off_string(key: str, parts: Sequence[Any], length: float) -> Iterator[Problem]:
    """Problems of parts under a key whose distance from the bit is beyond the length of the string [m]."""
    for index, part in enumerate(parts):
        if part.distance_from_bit > length * (1.0 + 1e-12):
            yield (
                (key, index, "distance_from_bit"),
                (
                    f'expected "{part.name}" on the string ({length:.6g} m long), '
                    f"found {part.distance_from_bit:.6g} m from the bit"
                ),
            )


class String(Part):
    """The drillstring, from the bit (arc length 0) to the clamp at the top."""

    sections: Annotated[tuple[Section, ...], Field(min_length=1, max_length=1000)]
    """Sections FROM THE BIT UP."""
    marks: Annotated[tuple[Mark, ...], Field(max_length=100)] = ()
    """Marks, in any order."""
    discs: Annotated[tuple[Disc, ...], Field(max_length=100)] = ()
    """Rigid discs, tools and point masses, in any order."""
    supports: Annotated[tuple[Support, ...], Field(max_length=100)] = ()
    """Elastic supports, bearings and elastic roots, in any order."""
    bit_end: BitEnd = "sliding"
    """Constraint of the bit. `guided`: on the axis, no tilt, free axially and in spin; `pinned`: on the axis, tilt
    free; `sliding`: free laterally, no tilt; `free`: none; `stabilised`: `free` inside `effects.bit_stabiliser`."""

    top_end: Literal["clamped", "hinged", "free"] = "clamped"
    """Constraint of the top across the hole. `clamped`: on the axis, no tilt; `hinged`: on the axis, tilt free; `free`:
    none, supports hold it."""

    def problems(self) -> Iterator[Problem]:
        """A string that is too long, parts beyond its end, names that two parts have, and a top that nothing holds."""
        length = self.length
        if length > LONGEST_STRING:
            text = f"expected at most {LONGEST_STRING / 1000.0:g} km in all, found {length / 1000.0:.6g} km"
            yield ("sections",), text
        for key in ("marks", "discs", "supports"):
            yield from places_off_string(key, getattr(self, key), length)
            yield from repeated_names(key, getattr(self, key))
        for index, disc in enumerate(self.discs):
            shaft = self.section_at(disc.distance_from_bit).outer_diameter
            if disc.mass is None and disc.body(shaft)[0] <= 0.0:
                text = f"expected more than the string's ({shaft:.6g} m), found {disc.outer_diameter:.6g} m"
                yield ("discs", index, "outer_diameter"), text
        held = {part.distance_from_bit for part in self.supports if part.stiffness > 0.0 and part.stiffness_y != 0.0}
        if self.top_end == "free" and len(held) < (1 if self.bit_end in ("guided", "pinned") else 2):
            text = "expected supports with a stiffness at two places, a bit on the axis counted as one, found fewer"
            yield ("top_end",), text

    @property
    def stations(self) -> list[float]:
        """Distances from the bit of discs and supports [m]; the mesh has nodes there."""
        return [disc.distance_from_bit for disc in self.discs] + [one.distance_from_bit for one in self.supports]

    @property
    def length(self) -> float:
        """Length from bit to top clamp [m]."""
        return math.fsum(section.length for section in self.sections)

    @property
    def backs_off(self) -> str:
        """Clause on torque to the left; empty for a string without tool joints or make-up torque, as of a bench."""
        joined = any(one.joints or one.adjusted_mass or one.make_up_torque for one in self.sections)
        return "right-hand joints can back off, at a torque not computed here" if joined else ""

    def section_at(self, distance_from_bit: float) -> Section:
        """Section at an arc length from the bit [m]: the upper one at a joint of two, the top one beyond the
        end.
        """
        return self._piece_at(distance_from_bit).section

    def body_of(self, disc: Disc) -> tuple[float, float, float, float]:
        """Mass [kg], polar and diametral inertia [kg m^2] and volume [m^3] of a disc on this string."""
        return disc.body(self.section_at(disc.distance_from_bit).outer_diameter)

    def radius_at(self, distance_from_bit: float) -> float:
        """Radius in contact with the wall [m], blades and tool joints included, as for `section_at`."""
        return 0.5 * self._piece_at(distance_from_bit).contact_diameter

    @property
    def pieces(self) -> tuple[Piece, ...]:
        """Uniform pieces from the bit up; tool joints are pieces of their own."""
        return tuple(piece for section in self.sections for piece in section.pieces())

    def _piece_at(self, distance_from_bit: float) -> Piece:
        pieces = self.pieces
        tops = accumulate(piece.length for piece in pieces)
        return next((piece for piece, top in zip(pieces, tops, strict=True) if distance_from_bit < top), pieces[-1])
