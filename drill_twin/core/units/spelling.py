# SPDX-License-Identifier: Apache-2.0
"""Units as records and tables of others spell them (WITS, WITSML, LAS, Drillbotics): `WOB [kN]`, `RPM (rpm)`."""

from drill_twin.core.units.dimension import Dimension
from drill_twin.core.units.parse import factor_of
from drill_twin.core.units.registry import UnitError

_PRODUCT = str.maketrans("", "", " .*·-")
_AS_HERE = (
    "kN m", "N m", "daN m", "ft lbf", "kN", "N", "daN", "kgf", "tf", "lbf", "klbf", "rpm", "rev/s", "rad/s", "m", "ft",
    "s", "sec", "min", "h", "hr",
)  # fmt: skip
_SPELLINGS: dict[str, tuple[str, float]] = {unit.lower().translate(_PRODUCT): (unit, 1.0) for unit in _AS_HERE} | {
    "kdanm": ("daN m", 1000.0),
    "ftlb": ("ft lbf", 1.0),
    "ftlbs": ("ft lbf", 1.0),
    "lbfft": ("ft lbf", 1.0),
    "kftlb": ("ft lbf", 1000.0),
    "kftlbf": ("ft lbf", 1000.0),
    "klbfft": ("ft lbf", 1000.0),
    "kdan": ("daN", 1000.0),
    "kkgf": ("kgf", 1000.0),
    "t": ("tf", 1.0),
    "tonf": ("tf", 1.0),
    "lb": ("lbf", 1.0),
    "lbs": ("lbf", 1.0),
    "klb": ("klbf", 1.0),
    "klbs": ("klbf", 1.0),
    "1000lbf": ("klbf", 1.0),
    "1/min": ("rpm", 1.0),
    "c/min": ("rpm", 1.0),
    "rev/min": ("rpm", 1.0),
    "c/s": ("rev/s", 1.0),
    "rps": ("rev/s", 1.0),
    "f": ("ft", 1.0),
    "d": ("h", 24.0),
}
"""Spellings, lower case and without the sign of a product -> unit of this package, how many."""


def record_factor(unit: str, dimension: Dimension) -> float:
    """SI factor of a unit in a record: as this package writes it, else by the table of spellings.

    Raises:
        UnitError: It is none of the dimension.
    """
    try:
        return factor_of(unit, dimension)
    except UnitError:
        known, count = _SPELLINGS.get(unit.lower().translate(_PRODUCT), ("", 0.0))
        if not known:
            raise
        return count * factor_of(known, dimension)


def name_and_unit(heading: str) -> tuple[str, str]:
    """Split a heading into name and unit, without blanks around; the unit is empty where there is none.

    No regular expression: those for it take a time that grows with a power of the number of blanks.
    """
    text = heading.strip()
    begin = max(text.rfind("["), text.rfind("("))
    unit = text[begin + 1 : -1].strip()
    if begin < 0 or text[-1] not in "])" or not unit or "]" in unit or ")" in unit:
        return text, ""
    return text[:begin].strip(), unit
