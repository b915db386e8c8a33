# SPDX-License-Identifier: Apache-2.0
"""The `string:` part of a scene: sections from the bit up, marks, and the constraint of the bit."""

import math
from collections.abc import Iterator, Sequence
from typing import Annotated, Any, Literal

from pydantic import Field

from drill_twin.core.units import Length, Within
from drill_twin.physics.effects.config import Incompatibility
from drill_twin.scene.blocks.part import Part, Problem
from drill_twin.scene.blocks.section import Piece, Section

Name = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_]*$", max_length=60)]
"""Name that is valid inside a joint name on a topic."""

LONGEST_STRING = 20_000.0
"""Longest string [m]; the longest wells reach 15 km."""

BitEnd = Literal["guided", "pinned", "sliding", "free", "stabilised"]


class Mark(Part):
    """Point of the string at which motion is published and analysed."""

    name: Name
    """Name on the topics: letters, digits and underscores, a letter first."""
    distance_from_bit: Annotated[Length, Within(at_least="0 m", at_most="20 km")]
    """Arc length from the bit [m]."""
    on: Literal["wall", "centre"] = "wall"
    """`wall`: on the outer surface (on a blade, if any), rotating with the spin; `centre`: on the centre line."""


def repeated_names(key: str, parts: Sequence[Any]) -> Iterator[Problem]:
    """Problems of parts under a key whose name an earlier part has."""
    names = [part.name for part in parts]
    for index, name in enumerate(names):
        if name in names[:index]:
            yield (key, index, "name"), f'expected a name of its own, found "{name}" again'


def places_off_string(key: str, parts: Sequence[Any], length: float) -> Iterator[Problem]:
    """Problems of parts under a key whose distance from the bit is beyond the length of the string [m]."""
    for index, part in enumerate(parts):
        if part.distance_from_bit > length * (1.0 + 1e-12):
            yield Incompatibility(
                (key, index, "distance_from_bit"),
                f'expected "{part.name}" on the string ({length:.6g} m long), '
                f"found {part.distance_from_bit:.6g} m from the bit",
            )


class String(Part):
    """The drillstring, from the bit (arc length 0) to the clamp at the top."""

    sections: Annotated[tuple[Section, ...], Field(min_length=1, max_length=1000)]
    """Sections FROM THE BIT UP."""
    marks: Annotated[tuple[Mark, ...], Field(max_length=100)] = ()
    """Marks, in any order."""
    bit_end: BitEnd = "sliding"
    """Constraint of the bit. `guided`: on the axis, no tilt, free axially and in spin; `pinned`: on the axis, tilt
    free; `sliding`: free laterally, no tilt; `free`: none; `stabilised`: `free` inside `effects.bit_stabiliser`."""

    top_end: Literal["clamped", "hinged"] = "clamped"
    """Constraint of the top across the hole. `clamped`: on the axis, no tilt; `hinged`: on the axis, tilt free."""

    def problems(self) -> Iterator[Problem]:
        """A string that is too long, marks beyond its end, and names that two marks have."""
        length = self.length
        if length > LONGEST_STRING:
            text = f"expected at most {LONGEST_STRING / 1000.0:g} km in all, found {length / 1000.0:.6g} km"
            yield ("sections",), text
        yield from places_off_string("marks", self.marks, length)
        yield from repeated_names("marks", self.marks)

    @property
    def length(self) -> float:
        """Length from bit to top clamp [m]."""
        return math.fsum(section.length for section in self.sections)

    def section_at(self, distance_from_bit: float) -> Section:
        """Section at an arc length from the bit [m]: the upper of two at their joint, the last one beyond an end."""
        return self._piece_at(distance_from_bit).section

    def radius_at(self, distance_from_bit: float) -> float:
        """Radius in contact with the wall [m], blades and tool joints included, as for `section_at`."""
        return 0.5 * self._piece_at(distance_from_bit).contact_diameter

    @property
    def pieces(self) -> tuple[Piece, ...]:
        """Uniform pieces from the bit up; tool joints are pieces of their own."""
        return tuple(piece for section in self.sections for piece in section.pieces())

    def _piece_at(self, distance_from_bit: float) -> Piece:
        bottom = 0.0
        for piece in self.pieces:
            bottom += piece.length
            if distance_from_bit < bottom:
                return piece
        return self.pieces[-1]
