# SPDX-License-Identifier: Apache-2.0
"""The hole: a straight cylinder around the axis."""

from typing import Annotated

from drill_twin.scene.part import Part
from drill_twin.units import Angle, Length, Within


class Hole(Part):
    """The hole the string turns in."""

    radius: Annotated[Length, Within(above="0 m", at_most="10 m")]
    """Radius [m]."""
    inclination: Annotated[Angle, Within(at_least="0 deg", at_most="180 deg")] = 0.0
    """Angle of the axis from the vertical [rad]; the low side is +x."""
