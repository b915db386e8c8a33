# SPDX-License-Identifier: Apache-2.0
"""Units of results: SI with the prefixes of a rig or of a laboratory, or oil field units."""

from __future__ import annotations

from typing import NamedTuple

from drill_twin.core.units.registry import si_factor


class UnitSystem(NamedTuple):
    """Name of the unit of each quantity."""

    length: str
    force: str
    torque: str
    force_per_length: str
    stress: str

    def show(self, value: float, quantity: str) -> float:
        """Value in SI, in the unit of a quantity (`length`, `force`, ...)."""
        return value / si_factor(getattr(self, quantity))[0]


SI = UnitSystem("m", "kN", "kN m", "N/m", "MPa")
FIELD = UnitSystem("ft", "klbf", "klbf ft", "lbf/ft", "ksi")
LABORATORY = UnitSystem("m", "N", "N m", "N/m", "MPa")
WELL = 100.0
"""Length above which a string is one of a well [m]; the live page draws the line there too."""


def unit_system(name: str, length: float) -> UnitSystem:
    """System by its name, `si` or `field`; in SI that of the laboratory for a short string [m]."""
    return FIELD if name == "field" else SI if length > WELL else LABORATORY
