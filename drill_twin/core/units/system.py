# SPDX-License-Identifier: Apache-2.0
"""Units that people read: one table for tables, figures, pages and messages; files for machines stay in SI."""

from typing import Any, NamedTuple

from drill_twin.core.units.dimension import GRAVITY
from drill_twin.core.units.registry import si_factor


class UnitSystem(NamedTuple):
    """Name of a system and its unit of each quantity; values are converted only where they are shown."""

    name: str
    length: str
    offset: str
    """Of radii and of distances across the hole."""
    force: str
    torque: str
    force_per_length: str
    stress: str
    """Also of specific energy."""
    rotation: str
    rate: str
    """Of penetration."""
    acceleration: str

    def show(self, value: Any, quantity: str) -> Any:
        """Number or array in SI (rotation in rad/s), in the unit of a quantity: `length`, `force`, ..."""
        return value / _size(getattr(self, quantity))

    def number(self, value: float, quantity: str, form: str = "") -> str:
        """The same as text, in a format; by default four digits, of offsets a tenth of a mm."""
        shown = float(self.show(value, quantity))
        if not form:
            least, usual = (1.0, ".1f") if self.offset == "mm" else (0.02, ".3f")
            form = (usual if abs(shown) >= least else ".2g") if quantity == "offset" else ".4g"
            if 1e4 <= round(abs(shown)) < 1e6:
                form = ".0f"  # a depth of 12345 ft is read as such
        return f"{shown:{form}}"

    def text(self, value: float, quantity: str, form: str = "") -> str:
        """The same with its unit: `20 klbf`."""
        return f"{self.number(value, quantity, form)} {getattr(self, quantity)}"

    def in_unit(self, unit: str) -> tuple[float, str]:
        """Number of the reader's units in an SI unit of `QUANTITIES`, and their name; of another unit 1 and itself."""
        if unit not in QUANTITIES:
            return 1.0, unit
        return float(self.show(1.0, QUANTITIES[unit])), str(getattr(self, QUANTITIES[unit]))

    def set_point(self, weight: float, rotation: float) -> str:
        """Weight on bit [N] and speed [rad/s] as text: `20 klbf at 120 rpm`."""
        return f"{self.text(weight, 'force')} at {self.text(rotation, 'rotation')}"

    def span(self, low: float, high: float, quantity: str) -> str:
        """Range as text: `5 to 20 klbf`."""
        return f"{self.number(low, quantity)} to {self.text(high, quantity)}"


SYSTEMS = {
    "field": UnitSystem("field", "ft", "in", "klbf", "klbf ft", "lbf/ft", "ksi", "rpm", "ft/h", "g"),
    "si": UnitSystem("si", "m", "mm", "kN", "kN m", "N/m", "MPa", "rpm", "m/h", "g"),
    "lab": UnitSystem("lab", "m", "mm", "N", "N m", "N/m", "MPa", "rev/s", "m/h", "g"),
}
LONG, HEAVY = 100.0, 5000.0
"""Length [m] and weight on bit [N] from which a scene that names no units is shown in `si`, as a well, and not in
`lab`, as a test bench."""
QUANTITIES = {
    "m": "length", "N": "force", "N m": "torque", "N/m": "force_per_length", "Pa": "stress", "rad/s": "rotation",
    "m/s": "rate", "m/s^2": "acceleration",
}  # fmt: skip
"""Quantity by the SI unit of its values."""
_POUNDS = ("klbf", "lbf", "klb", "kip", "kips")


def unit_system(name: str, length: float = 0.0, weight: float = 0.0) -> UnitSystem:
    """System of a name; for `auto` the system that fits a string [m] and its weight on bit [N]."""
    return SYSTEMS["si" if abs(length) > LONG or abs(weight) >= HEAVY else "lab"] if name == "auto" else SYSTEMS[name]


def typed_in_pounds(text: object) -> bool:
    """True for a force that is written in pounds, as `20 klbf`."""
    return isinstance(text, str) and text.strip().endswith(_POUNDS)


def _size(unit: str) -> float:
    return GRAVITY if unit == "g" else si_factor(unit)[0]
