# SPDX-License-Identifier: Apache-2.0
"""Parsing and writing of quantities with units, such as `"40 N"` or `"12 1/4 in"`, with a check of the dimension.

Records and tables (WITS, WITSML, LAS, Drillbotics) spell units in a way of their own: `WOB [kN]`, `RPM (rpm)`.
"""

import difflib
import math
import re
from functools import cache

from drill_twin.core.numerals import NUMBER
from drill_twin.core.units.dimension import DIMENSIONLESS, DIMENSIONS, Dimension
from drill_twin.core.units.registry import (
    UNIT_NAMES,
    Dimensionality,
    UnitError,
    UnknownUnitError,
    short_names,
    si_factor,
    tidy,
)

_FRACTION = r"(?:\s+(\d{1,9})/(\d{1,9})|/(\d{1,9}))?"
_MARKS = {'"': "in", "″": "in", "”": "in", "'": "ft", "′": "ft", "’": "ft"}
"""Units by their signs, as in `8 1/2"`."""
_QUANTITY = re.compile(rf"\s*({NUMBER}){_FRACTION}(?:(?<=[\d.])|\s)\s*([^\d\s.+-].*)?", re.DOTALL | re.ASCII)


def parse(text: str, dimension: Dimension) -> float:
    """Parse a text such as `"40 N"` to its SI value; raises UnitError with expected and found."""
    value, unit = split(text, dimension)
    factor, found = _factor_or_raise(unit, text, dimension)
    if found not in (accepted := _accepted(dimension)):
        what = dimension_name(found)
        near = f', did you mean "{unit}f"?' if f"{unit}f" in _simple_units(dimension, short_names()) else ""
        raise UnitError(f'expected {dimension.expected}, found "{short(text)}" ({what if unit else "no unit"}){near}')
    factor *= accepted[found]
    result = value if factor == 1.0 else tidy(value * factor)
    if not math.isfinite(result):
        raise UnitError(f'expected a finite {dimension.name}, found "{short(text)}"')
    return result


def split(text: str, dimension: Dimension) -> tuple[float, str]:
    """Split a text into number and unit; fractions such as `12 1/4 in` and `1/2 in` are read, `"` is in and `'` ft."""
    match = _QUANTITY.fullmatch(text)
    if match is None:
        raise UnitError(f'expected {dimension.expected}, found "{short(text)}" (not a number with a unit)')
    number, numerator, mixed, simple, unit = match.groups()
    value = float(number)
    if int(mixed or 1) == 0 or int(simple or 1) == 0:
        raise UnitError(f'expected {dimension.expected}, found "{short(text)}" (division by zero)')
    if mixed:
        value += math.copysign(int(numerator) / int(mixed), value)
    if simple:
        value /= int(simple)
    unit = (unit or "").strip()
    return value, _MARKS.get(unit, unit)


def factor_of(unit: str, dimension: Dimension) -> float:
    """SI factor of a unit, for columns of numbers; raises UnitError if it has another dimension."""
    factor, found = _factor_or_raise(unit, unit, dimension)
    if found not in (accepted := _accepted(dimension)):
        raise UnitError(f'expected a unit of {dimension.name} such as "{dimension.unit}", found "{short(unit)}"')
    return factor * accepted[found]


def write(value: float, dimension: Dimension) -> str:
    """Text of an SI value that `parse` reads back to the same float: `0.0165 m`."""
    return f"{value!r} {dimension.unit}".rstrip()


def dimension_name(dimensionality: Dimensionality) -> str:
    """Name of a dimensionality for messages: `mass`, or its powers if it has none."""
    named = _named(dimensionality)
    if named:
        return named.name
    return " ".join(f"{base.strip('[]')}^{power:g}" for base, power in dimensionality)


def dimension_of(text: str) -> Dimension:
    """Dimension of a quantity's text, such as a bound; raises UnitError if it is not in the table."""
    _, unit = split(text, DIMENSIONLESS)
    named = _named(si_factor(unit)[1])
    if named is None:
        raise UnitError(f'expected a dimension known to scenes, found "{text}"')
    return named


def _named(dimensionality: Dimensionality) -> Dimension | None:
    return next((known for known in DIMENSIONS if dimensionality == si_factor(known.unit)[1]), None)


@cache
def _accepted(dimension: Dimension) -> dict[Dimensionality, float]:
    """Dimensionalities accepted for a dimension, each with the factor that turns its SI value into the dimension."""
    same = {si_factor(unit)[1]: 1.0 for unit in (dimension.unit, *dimension.also)}
    return same | {si_factor(unit)[1]: factor for unit, factor in dimension.converted}


def _factor_or_raise(unit: str, text: str, dimension: Dimension) -> tuple[float, Dimensionality]:
    try:
        return si_factor(unit)
    except UnknownUnitError as error:
        what = _unknown_unit(str(error), dimension)
        raise UnitError(f'expected {dimension.expected}, found "{short(text)}": {what}') from None
    except UnitError as error:
        raise UnitError(f'expected {dimension.expected}, found "{short(text)}": {error}') from None


def short(text: str) -> str:
    """Shorten a text to one line of at most 60 characters, for messages."""
    line = " ".join(text.split())
    return line if len(line) <= 60 else line[:57] + "..."


@cache
def editor_pattern(dimension: Dimension) -> str:
    """Regular expression (ECMA 262) for texts of a dimension: simple units by name, products of units by shape."""
    fitting = sorted(_simple_units(dimension, (*short_names(), *UNIT_NAMES)), key=lambda name: (-len(name), name))
    simple = "|".join(fitting)
    product = r"[^\s0-9]+\s*[*·/^ ]\s*\S.*"
    number = r"[+-]?([0-9]+(\.[0-9]*)?|\.[0-9]+)([eE][+-]?[0-9]+)?(\s+[0-9]+/[0-9]+|/[0-9]+)?"
    unit = rf"({simple}|{product})" if simple else rf"({product})"
    return rf"^\s*{number}\s*{unit}{'' if dimension.unit else '?'}\s*$"


def _unknown_unit(name: str, dimension: Dimension) -> str:
    """Message with the nearest unit of the expected dimension, else of any."""
    for known in (_simple_units(dimension, short_names()), short_names()):
        same = [unit for unit in known if unit.lower() == name.lower()]
        near = same or difflib.get_close_matches(name, known, n=1, cutoff=0.5)
        if near:
            return f'"{name}" is not a known unit, did you mean "{near[0]}"?'
    return f'"{name}" is not a known unit'


@cache
def _simple_units(dimension: Dimension, names: tuple[str, ...]) -> list[str]:
    """Select the names that are units of the dimension."""
    return [name for name in names if si_factor(name)[1] in _accepted(dimension)]


_PRODUCT = str.maketrans("", "", " .*·-")
_AS_HERE = (
    "kN m", "N m", "daN m", "ft lbf", "kN", "N", "daN", "kgf", "tf", "lbf", "klbf", "rpm", "rev/s", "rad/s", "m", "ft",
    "s", "sec", "min", "h", "hr",
)  # fmt: skip
_OTHERS = {
    ("daN m", 1000.0): "kdanm", ("ft lbf", 1.0): "ftlb ftlbs lbfft", ("ft lbf", 1000.0): "kftlb kftlbf klbfft",
    ("daN", 1000.0): "kdan", ("kgf", 1000.0): "kkgf", ("tf", 1.0): "t tonf", ("lbf", 1.0): "lb lbs",
    ("klbf", 1.0): "klb klbs 1000lbf", ("rpm", 1.0): "1/min c/min rev/min", ("rev/s", 1.0): "c/s rps",
    ("ft", 1.0): "f", ("h", 24.0): "d",
}  # fmt: skip
"""Unit of this package, how many -> other spellings of it."""
_SPELLINGS: dict[str, tuple[str, float]] = {unit.lower().translate(_PRODUCT): (unit, 1.0) for unit in _AS_HERE} | {
    spelling: meant for meant, spellings in _OTHERS.items() for spelling in spellings.split()
}
"""Spellings, lower case and without the sign of a product -> unit of this package, how many."""


def record_factor(unit: str, dimension: Dimension) -> float:
    """SI factor of a unit in a record: as this package writes it, else by the table of spellings.

    Raises:
        UnitError: The text is no unit of the dimension.
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

    A regular expression for this takes a time that grows with a power of the number of blanks.
    """
    text = heading.strip()
    begin = max(text.rfind("["), text.rfind("("))
    unit = text[begin + 1 : -1].strip()
    if begin < 0 or text[-1] not in "])" or not unit or "]" in unit or ")" in unit:
        return text, ""
    return text[:begin].strip(), unit
