# SPDX-License-Identifier: Apache-2.0
"""The `severity:` part of a scene: the bounds from which a motion is low, medium, high and severe for its tools."""

from collections.abc import Iterator
from itertools import pairwise
from typing import Annotated, Any

from pydantic import Field, SerializerFunctionWrapHandler, model_serializer

from drill_twin.core import severity
from drill_twin.core.units import Acceleration, Dimensionless, Force, Pressure
from drill_twin.physics.effects.config import Part, Problem

_FOUR = Field(min_length=4, max_length=4)


class SeverityBounds(Part):
    """Bounds of the grades low, medium, high and severe, rising; what is left out has a bound of this program."""

    source: Annotated[str, Field(min_length=1, max_length=500)]
    """Source of the bounds, such as the manual of a tool."""
    lateral_rms: Annotated[tuple[Acceleration, ...], _FOUR] = severity.DEFAULT.lateral_rms
    """Lateral acceleration of the centre line, root mean square."""
    lateral_peak: Annotated[tuple[Acceleration, ...], _FOUR] = severity.DEFAULT.lateral_peak
    """Lateral acceleration of the centre line, largest."""
    axial_rms: Annotated[tuple[Acceleration, ...], _FOUR] = severity.DEFAULT.axial_rms
    """Axial acceleration, root mean square."""
    axial_peak: Annotated[tuple[Acceleration, ...], _FOUR] = severity.DEFAULT.axial_peak
    """Axial acceleration, largest."""
    bending_stress: Annotated[tuple[Pressure, ...], _FOUR] = severity.DEFAULT.bending_stress
    """Half of the range of bending stress."""
    wall_force: Annotated[tuple[Force, ...], _FOUR] = severity.DEFAULT.wall_force
    """Mean force of the wall on the length of a joint, 30 ft."""
    stick_slip: Annotated[tuple[Dimensionless, ...], _FOUR] = severity.DEFAULT.stick_slip
    """Stick-slip index of the bit."""

    def problems(self) -> Iterator[Problem]:
        """Bounds that do not rise from above zero, and a source without bounds."""
        if not self._given:
            yield (), "expected bounds of a quantity beside their source, found none; add bounds"
        for key in self._given:
            values = (0.0, *getattr(self, key))
            if any(low >= high for low, high in pairwise(values)):
                unit = severity.UNITS[key].strip("-")
                shown = f"{', '.join(f'{value:g}' for value in values[1:])} {unit}".strip()
                yield (key,), f"expected four bounds above 0, each larger than the one before, found {shown}"

    @model_serializer(mode="wrap")
    def _own(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Source and the bounds that are given, so that a scene that is read again names the source for no others."""
        return {key: value for key, value in handler(self).items() if key in self.model_fields_set}

    @property
    def _given(self) -> list[str]:
        return [key for key in severity.Bounds._fields if key in self.model_fields_set]

    @property
    def whose(self) -> str:
        """Source, and of which quantities where the block does not give the bounds of all."""
        if len(self._given) == len(severity.WORDS):
            return self.source
        names = ", ".join(severity.WORDS[key].replace(",", "") for key in self._given)
        return f"{self.source}, for {names}; for the others {severity.OF_THIS_PROGRAM}"

    @property
    def bounds(self) -> severity.Bounds:
        """Bounds by quantity."""
        return severity.Bounds(*(getattr(self, key) for key in severity.Bounds._fields))
