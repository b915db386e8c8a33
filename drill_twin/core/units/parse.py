# SPDX-License-Identifier: Apache-2.0
"""Parsing and writing of quantities with units, such as `"40 N"` or `"12 1/4 in"`, with a check of the dimension.

Records and tables (WITS, WITSML, LAS, Drillbotics) spell units in a way of their own: `WOB [kN]`, `RPM (rpm)`.
"""

import difflib
import math
import re
from functools import cache

from drill_twin.core.numerals import NUMBER
from drill_twin.core.units.dimension import ACCELERATION, DIMENSIONS, GRAVITY, Dimension
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
    factor = factor_of(unit, dimension, text)
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


def factor_of(unit: str, dimension: Dimension, text: str = "") -> float:
    """SI factor of a unit; raises UnitError if it has another dimension, found in `text` or in the unit alone."""
    factor, found = _factor_or_raise(unit, text or unit, dimension)
    if found not in (accepted := _accepted(dimension)):
        what = dimension_name(found)
        near = f', did you mean "{unit}f"?' if f"{unit}f" in _simple_units(dimension, short_names()) else ""
        told = f'"{short(text or unit)}" ({what if unit else "no unit"}){near}'
        expected = dimension.expected if text else f'a unit of {dimension.name} such as "{dimension.unit}"'
        raise UnitError(f"expected {expected}, found {told}")
    return factor * accepted[found]


def write(value: float, dimension: Dimension) -> str:
    """Text of an SI value that `parse` reads back to the same float: `0.0165 m`."""
    return f"{value!r} {dimension.unit}".rstrip()


def dimension_name(dimensionality: Dimensionality) -> str:
    """Name of a dimensionality for messages: `mass`, or its powers if it has none."""
    powers = " ".join(f"{base.strip('[]')}^{power:g}" for base, power in dimensionality)
    return next((known.name for known in DIMENSIONS if dimensionality == si_factor(known.unit)[1]), powers)


@cache
def _accepted(dimension: Dimension) -> dict[Dimensionality, float]:
    """Dimensionalities accepted for a dimension, each with the factor that turns its SI value into the dimension."""
    same = {si_factor(unit)[1]: 1.0 for unit in (dimension.unit, *dimension.also)}
    return same | {si_factor(unit)[1]: factor for unit, factor in dimension.converted}


def _factor(unit: str, dimension: Dimension) -> tuple[float, Dimensionality]:
    """SI factor and dimensionality; `g` is the gram, and of an acceleration standard gravity."""
    return (GRAVITY, si_factor(dimension.unit)[1]) if (unit, dimension) == ("g", ACCELERATION) else si_factor(unit)


def _factor_or_raise(unit: str, text: str, dimension: Dimension) -> tuple[float, Dimensionality]:
    try:
        return _factor(unit, dimension)
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
    return [name for name in names if _factor(name, dimension)[1] in _accepted(dimension)]


_PRODUCT = str.maketrans("", "", " .*·-_")
_AS_HERE = (
    "kN m", "N m", "daN m", "ft lbf", "kN", "N", "daN", "kgf", "tf", "lbf", "klbf", "rpm", "rev/s", "rad/s", "m", "ft",
    "s", "sec", "min", "h", "hr", "ms", "kgf m", "tf m", "deg/s", "MN", "MN m",
)  # fmt: skip
_OTHERS = {
    ("daN m", 1000.0): "kdanm kdnm", ("ft lbf", 1.0): "ftlb ftlbs lbfft lbft lbsft ftlbfs",
    ("ft lbf", 1000.0): "kftlb kftlbs kftlbf klbfft klbft klbsft ftklb ftklbs ftklbf kipft kipsft ftkip ftkips "
    "1000ftlb 1000ftlbs 1000ftlbf 1000lbft 1000lbfft", ("kgf m", 1.0): "kgm mkgf mkg", ("kgf m", 1000.0): "kkgfm kkgm",
    ("tf m", 1.0): "tm tonm tonnem", ("daN", 1000.0): "kdan kdn", ("daN", 1.0): "dan",
    ("kgf", 1000.0): "kkgf kkg 1000kgf 1000kg", ("kgf", 1.0): "kg kgs",
    ("tf", 1.0): "t tonf tonne tonnes mt mton metricton metrictons ton tons te", ("lbf", 1.0): "lb lbs pound pounds",
    ("klbf", 1.0): "klb klbs 1000lbf 1000lb 1000lbs kip kips klbfs kpound kpounds",
    ("rpm", 1.0): "1/min c/min rev/min r/min revs/min revolutions/minute u/min tr/min",
    ("rev/s", 1.0): "c/s rps r/s", ("ft", 1.0): "f feet foot", ("m", 1.0): "meter meters metre metres",
    ("s", 1.0): "secs second seconds", ("min", 1.0): "mins minute minutes", ("h", 1.0): "hrs hour hours",
    ("h", 24.0): "d day days", ("ms", 1.0): "msec millisecond milliseconds", ("ms", 1e-3): "us usec",
    ("ms", 1e-6): "ns nsec", ("in", 1.0): 'in "', ("lb/ft", 1.0): "ppf #/ft lbs/ft lbm/ft lbf/ft lb/foot lbs/foot",
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


def unit_here(spelling: str) -> str:
    """Unit as this package writes it, where a spelling of the trade is another name of it; else the spelling."""
    unit, count = _SPELLINGS.get(spelling.lower().translate(_PRODUCT), ("", 0.0))
    return unit if count == 1.0 else spelling


AMBIGUOUS = {
    "ton": "tonnes-force of 1,000 kgf", "tons": "tonnes-force of 1,000 kgf", "lb": "pounds-force",
    "lbs": "pounds-force", "kg": "kilograms-force",
}  # fmt: skip
"""Units that may mean something else, lower case, and what each is taken for in a record."""
_NO_UNIT = {"", "unitless", "none", "-", "--", "----", "text", "euc", "n/a"}
_CLOCK = re.compile(r"[ymdhs:/.\-,\s]{0,20}(?:yy|dd|hh)[ymdhs:/.\-,\s]{0,30}", re.IGNORECASE)


def is_unit(text: str) -> bool:
    """True for a unit of any quantity, as in a row of units below the header of a record."""
    if {text.lower(), text.lower().translate(_PRODUCT)} & {*_NO_UNIT, *_SPELLINGS} or _CLOCK.fullmatch(text):
        return True
    try:
        return bool(si_factor(text))
    except UnitError:
        return False


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
