# SPDX-License-Identifier: Apache-2.0
"""Blocks of `drill_twin.physics.effects.fatigue`: a cross-section whose stress is counted, and an S-N curve of one
slope.
"""

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from drill_twin.core.units import Dimensionless, Length, Pressure, Within, refuse
from drill_twin.physics.effects.config import EffectConfig
from drill_twin.physics.model.steel import GRADES, Steel, steel_of

Grade = Literal["E75", "X95", "G105", "S135"]


class FatigueSection(EffectConfig):
    """Cross-section of the string whose stress is counted."""

    name: Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_]*$", max_length=60)]
    """Name on the topic: letters, digits and underscores, a letter first."""
    distance_from_bit: Annotated[Length, Within(at_least="0 m", at_most="20 km")] | None = None
    """Arc length from the bit [m]; either this or `measured_depth`."""
    measured_depth: Annotated[Length, Within(at_least="0 m", at_most="20 km")] | None = None
    """Distance from the top along the string [m]."""
    grade: Grade | None = None
    """Grade of its steel; left out: by the yield strength of the string's section there, else E75."""
    stress_concentration: Annotated[Dimensionless, Within(at_least="1", at_most="20")] = 1.0
    """Local over nominal stress range, as of a connection; the published stress is nominal."""

    @model_validator(mode="after")
    def _has_one_place(self) -> Self:
        if (self.distance_from_bit is None) == (self.measured_depth is None):
            found = "none" if self.distance_from_bit is None else "both"
            raise refuse(f"expected either `distance_from_bit` or `measured_depth`, found {found}")
        return self

    def distance(self, length: float) -> float:
        """Arc length from the bit [m], of a string of a length [m]."""
        return length - self.measured_depth if self.measured_depth is not None else self.distance_from_bit or 0.0

    def steel(self, yield_strength: float | None) -> Steel:
        """Its steel, in a section of the string with a yield strength [Pa]."""
        return GRADES[self.grade] if self.grade is not None else steel_of(yield_strength)


class SNLine(EffectConfig):
    """S-N curve of one slope: N = cycles (stress_range / S)^slope."""

    stress_range: Annotated[Pressure, Within(above="0 Pa", at_most="100 GPa")]
    """Stress range [Pa] that is endured for `cycles`."""
    cycles: Annotated[Dimensionless, Within(at_least="1", at_most="1e12")] = 1e6
    """Cycles to failure at that range."""
    slope: Annotated[Dimensionless, Within(at_least="1", at_most="30")]
    """Slope m."""
