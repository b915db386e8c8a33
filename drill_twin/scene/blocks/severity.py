# SPDX-License-Identifier: Apache-2.0
"""The `severity:` part of a scene: the bounds from which a motion is low, medium, high and severe for its tools."""

from collections.abc import Iterator
from itertools import pairwise
from typing import Annotated

from pydantic import Field

from drill_twin.core import severity
from drill_twin.core.units import Acceleration, Dimensionless, Force, Pressure
from drill_twin.scene.blocks.part import Part, Problem

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
        """Bounds that do not rise from above zero."""
        for key in severity.Bounds._fields:
            values = (0.0, *getattr(self, key))
            if any(low >= high for low, high in pairwise(values)):
                shown = ", ".join(f"{value:g}" for value in values[1:])
                yield (key,), f"expected four bounds above 0, each larger than the one before, found {shown}"

    @property
    def bounds(self) -> severity.Bounds:
        """Bounds by quantity."""
        return severity.Bounds(*(getattr(self, key) for key in severity.Bounds._fields))
