# SPDX-License-Identifier: Apache-2.0
"""Units of scenes and their SI factors: those of drilling and laboratories, with prefixes, products and powers.

The angle is a dimension: `2 Hz` is then not mistaken for a speed of rotation.
"""

import math
import re
from collections import Counter
from collections.abc import Iterator
from functools import cache

from drill_twin.core.errors import SceneError

DEFINITIONS: dict[str, tuple[float, str]] = {
    "m meter meters metre metres": (1.0, "[length]"),
    "s second seconds sec": (1.0, "[time]"),
    "kg": (1.0, "[mass]"),
    "g gram grams": (1e-3, "kg"),
    "rad radian radians": (1.0, "[angle]"),
    "deg degree degrees": (0.017453292519943295, "rad"),
    "rev revolution revolutions turn turns": (6.283185307179586, "rad"),
    "in inch inches": (0.0254, "m"),
    "ft foot feet": (12.0, "in"),
    "min minute minutes": (60.0, "s"),
    "h hour hours hr": (60.0, "min"),
    "rpm": (1.0, "rev/min"),
    "Hz hertz": (1.0, "1/s"),
    "t tonne tonnes": (1000.0, "kg"),
    "lb pound pounds": (0.45359237, "kg"),
    "L l liter liters litre litres": (1.0, "dm^3"),
    "gal gallon gallons": (231.0, "in^3"),
    "bbl": (42.0, "gal"),
    "ppg": (1.0, "lb/gal"),
    "sg SG": (1.0, "g/cm^3"),
    "N newton newtons": (1.0, "kg m/s^2"),
    "lbf": (4.4482216152605, "N"),
    "klbf klb kip kips": (1000.0, "lbf"),
    "kgf": (9.80665, "N"),
    "tf": (1000.0, "kgf"),
    "daN": (10.0, "N"),
    "Pa pascal pascals": (1.0, "N/m^2"),
    "bar": (1e5, "Pa"),
    "cP": (1e-3, "Pa s"),
    "psi": (1.0, "lbf/in^2"),
    "ksi": (1000.0, "psi"),
    "J joule joules": (1.0, "N m"),
    "W watt watts": (1.0, "J/s"),
    "percent": (0.01, ""),
}
"""Names of a unit -> how many of another unit; the four base units by their dimension."""

PREFIXED = ("m", "s", "g", "N", "Pa", "bar", "Hz", "rad", "J", "W", "L", "l")
PREFIXES = {
    "": 1.0, "k": 1e3, "M": 1e6, "G": 1e9, "m": 1e-3, "c": 1e-2, "d": 1e-1, "u": 1e-6, "µ": 1e-6, "μ": 1e-6, "n": 1e-9,
}  # fmt: skip
PLAIN = (
    "in", "ft", "min", "h", "deg", "°", "rev", "rpm", "t", "lb", "lbf", "klbf", "klb", "kip", "kips", "kgf", "tf",
    "daN", "psi", "ksi", "gal", "bbl", "ppg", "sg", "SG", "cP", "percent", "%",
)  # fmt: skip
UNIT_NAMES = (
    "meter", "meters", "metre", "metres", "inch", "inches", "foot", "feet", "second", "seconds", "sec",
    "minute", "minutes", "hour", "hours", "hr", "gram", "grams", "tonne", "tonnes", "pound", "pounds", "newton",
    "newtons", "pascal", "pascals", "joule", "joules", "watt", "watts", "hertz", "radian", "radians", "degree",
    "degrees", "revolution", "revolutions", "turn", "turns", "liter", "liters", "litre", "litres", "gallon",
    "gallons",
)  # fmt: skip
"""Accepted long names."""

Dimensionality = tuple[tuple[str, float], ...]
"""Base dimensions and their powers, sorted; empty for a number."""

_LONGEST_UNIT = 40
_UNIT = re.compile(r"(?:\s*(?:1\s*)?/)?(?:[A-Za-zµμ%°()·*/\s]|(?<=[A-Za-zµμ%)])\^\(?-?\d(?:\.\d{1,2})?(?![\d.]))*")
_POWER = re.compile(r"(?<=[A-Za-z])(?=[23](?![\d.]))")
"""Place of the sign of a power in `cm3`."""
_COURSE = re.compile(r"(deg|°|rad)\s*/\s*(30|10|100)\s*(m|ft)")
"""Curvature over a course length: `deg/30 m`, `deg/100 ft`."""
_WORD = re.compile(r"[A-Za-zµμ]+|[%°]")
_TOKEN = re.compile(r"\s*([A-Za-zµμ]+|[1*/()]|\^-?[\d.]+|\^\(-?[\d.]+\)|\S)\s*")


class UnitError(SceneError, ValueError):
    """A text that is not a number with a known unit of the expected dimension."""


class UnknownUnitError(UnitError):
    """A name that is no unit of the registry; the only argument is the name."""


@cache
def si_factor(unit: str) -> tuple[float, Dimensionality]:
    """SI factor and dimensionality of a unit text; raises UnitError if there is no such unit."""
    if course := _COURSE.fullmatch(unit.strip()):
        factor, dimensionality = si_factor(f"{course[1]}/{course[3]}")
        return tidy(factor / float(course[2])), dimensionality
    text = _POWER.sub("^", unit.replace("**", "^").replace("²", "^2").replace("³", "^3"))
    if len(text) > _LONGEST_UNIT or not _UNIT.fullmatch(text):
        raise UnitError(f'"{" ".join(unit.split())[:_LONGEST_UNIT]}" is not a unit')
    for name in _WORD.findall(text):
        if name not in _known():
            raise UnknownUnitError(name)
    text = text.replace("·", "*").replace("°", " deg ").replace("%", " percent ").strip()
    text = f"1{text}" if text.startswith("/") else text
    numbers, bases = Counter[float](), Counter[str]()
    try:
        for number, base, power in _parts(text, 1.0):
            numbers[number] += power
            bases[base] += power
        factor = math.prod(number**power for number, power in sorted(numbers.items(), key=lambda one: one[1] < 0.0))
    except (ArithmeticError, IndexError, ValueError):
        raise UnitError(f'"{" ".join(unit.split())}" is not a unit') from None
    return tidy(factor), tuple(sorted((base, power) for base, power in bases.items() if base and power))


def _parts(unit: str, power: float) -> Iterator[tuple[float, str, float]]:
    """Numbers in a power of a product of units, each with its base dimension or "", and its power.

    Raises:
        IndexError, ValueError: The product is malformed, such as `N(` or `m/`.
    """
    tokens = [*_TOKEN.findall(unit), ")"][::-1]
    units = _product(tokens).items() if unit else ()
    if unit and tokens:
        raise ValueError("a parenthesis too many")
    for name, exponent in units:
        number, of_unit = _definition(name)
        is_base = of_unit.startswith("[")
        yield number, of_unit if is_base else "", exponent * power
        yield from () if is_base else _parts(of_unit, exponent * power)


def _product(tokens: list[str]) -> "Counter[str]":
    """Take a product and its closing parenthesis from the end of reversed tokens: its units and their powers."""
    found = Counter[str]()
    side, complete = 1.0, False
    while (token := tokens.pop()) != ")":
        if token in {"*", "/"}:
            if not complete:
                raise ValueError("nothing before the sign")
            side, complete = {"*": 1.0, "/": -1.0}[token], False
            continue
        units = _product(tokens) if token.startswith("(") else Counter({token: 1.0} if token.isalpha() else {})
        if not units and not token.startswith("1"):
            raise ValueError("neither a unit nor a product")
        power = side * float(tokens.pop().strip("^()")) if tokens[-1][0] == "^" else side
        found.update({name: exponent * power for name, exponent in units.items()})
        side, complete = 1.0, True
    if not complete:
        raise ValueError("nothing after the sign")
    return found


@cache
def _definition(name: str) -> tuple[float, str]:
    """Number and unit that define a unit, by one of its names or by its prefix."""
    return next(
        (found for names, found in DEFINITIONS.items() if name in names.split()), (PREFIXES.get(name[0], 0.0), name[1:])
    )


def tidy(value: float) -> float:
    """Remove the rounding error of a conversion: the value rounded to 12 digits, if that is within 4e-16 of it."""
    short = float(f"{value:.12g}")
    return short if abs(short - value) <= 4e-16 * abs(value) else value


@cache
def short_names() -> tuple[str, ...]:
    """Short names, those without prefix first."""
    return (*PREFIXED, *PLAIN, *(prefix + unit for unit in PREFIXED for prefix in PREFIXES if prefix))


@cache
def _known() -> frozenset[str]:
    return frozenset((*short_names(), *UNIT_NAMES))
