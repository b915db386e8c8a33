# SPDX-License-Identifier: Apache-2.0
"""Units of results: SI with the prefixes of a rig, or oil field units."""

from __future__ import annotations

from typing import NamedTuple

from drill_twin.units.registry import si_factor


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
SYSTEMS = {"si": SI, "field": FIELD}
