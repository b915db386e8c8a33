# SPDX-License-Identifier: Apache-2.0
"""Units of scenes and their SI factors.

pint does the algebra. Its own registry of a thousand units takes 0.2 s to load; this one holds the units of drilling
and laboratories, with the angle as a dimension: `2 Hz` is then not mistaken for a speed of rotation.
"""

import atexit
import logging
import re
from contextlib import suppress
from functools import cache
from importlib.metadata import version
from pathlib import Path
from tokenize import TokenError
from typing import TYPE_CHECKING

from drill_twin.core.errors import RunError, SceneError
from drill_twin.core.files.kept_files import CheckedFiles, permanent_folder

if TYPE_CHECKING:
    import pint

DEFINITIONS = """
nano- = 1e-9 = n-
micro- = 1e-6 = µ- = μ- = u-
milli- = 1e-3 = m-
centi- = 1e-2 = c-
deci- = 1e-1 = d-
kilo- = 1e3 = k-
mega- = 1e6 = M-
giga- = 1e9 = G-
meter = [length] = m = metre
second = [time] = s = sec
kilogram = [mass] = kg
gram = 0.001 * kilogram = g
radian = [angle] = rad
degree = 0.017453292519943295 * radian = deg
revolution = 6.283185307179586 * radian = rev = turn
inch = 0.0254 * meter = in = inches
foot = 12 * inch = ft = feet
minute = 60 * second = min
hour = 60 * minute = h = hr
rpm = revolution / minute
hertz = 1 / second = Hz
tonne = 1000 * kilogram = t
pound = 0.45359237 * kilogram = lb
liter = decimeter ** 3 = L = litre = l
gallon = 231 * inch ** 3 = gal
barrel = 42 * gallon = bbl
ppg = pound / gallon
specific_gravity = gram / centimeter ** 3 = sg = SG
newton = kilogram * meter / second ** 2 = N
pound_force = 4.4482216152605 * newton = lbf
kip = 1000 * pound_force = klbf = kips = klb
kilogram_force = 9.80665 * newton = kgf
tonne_force = 1000 * kilogram_force = tf
decanewton = 10 * newton = daN
pascal = newton / meter ** 2 = Pa
bar = 1e5 * pascal
centipoise = 0.001 * pascal * second = cP
psi = pound_force / inch ** 2
ksi = 1000 * psi
joule = newton * meter = J
watt = joule / second = W
percent = 0.01 = %
"""

PREFIXED = ("m", "s", "g", "N", "Pa", "bar", "Hz", "rad", "J", "W", "L", "l")
PREFIXES = ("", "k", "M", "G", "m", "c", "d", "u", "µ", "μ", "n")
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
"""Accepted long names; pint alone would also accept the plural `Ns` for `N`."""

Dimensionality = tuple[tuple[str, float], ...]
"""Base dimensions and their powers, sorted; empty for a number."""

_LONGEST_UNIT = 40
_MOST_KEPT = 1000
"""Unit texts that are kept on disk; scenes, records and schema have some 300."""
_UNIT = re.compile(r"(?:\s*(?:1\s*)?/)?(?:[A-Za-zµμ%°()·*/\s]|(?<=[A-Za-zµμ%)])\^\(?-?\d(?:\.\d{1,2})?(?![\d.]))*")
_POWER = re.compile(r"(?<=[A-Za-z])(?=[23](?![\d.]))")
"""Place of the sign of a power in `cm3`."""
_COURSE = re.compile(r"(deg|°|rad)\s*/\s*(30|10|100)\s*(m|ft)")
"""Curvature over a course length: `deg/30 m`, `deg/100 ft`."""
_WORD = re.compile(r"[A-Za-zµμ]+|[%°]")


class UnitError(SceneError, ValueError):
    """A text that is not a number with a known unit of the expected dimension."""


class UnknownUnitError(UnitError):
    """A name that is no unit of the registry; the only argument is the name."""


@cache
def registry() -> "pint.UnitRegistry[float]":
    """The pint registry, built once in a few milliseconds; the import of pint takes longer, so it waits until here."""
    import pint

    units: pint.UnitRegistry[float] = pint.UnitRegistry(None)
    units.load_definitions(DEFINITIONS.strip().splitlines())
    return units


@cache
def _kept() -> dict[str, tuple[float, Dimensionality]]:
    """Factors that pint found in earlier processes, by unit text; what this process adds is kept at its end."""
    with suppress(RunError):  # a folder that cannot be used is refused where kernels are kept
        if folder := permanent_folder():
            key = (DEFINITIONS, version("pint"), Path(__file__).read_bytes())
            file = CheckedFiles(folder, "units", "factors", level=logging.DEBUG)
            found: dict[str, tuple[float, Dimensionality]] = file.load(key) or {}
            before = len(found)
            atexit.register(lambda: file.save(key, found) if before < len(found) <= _MOST_KEPT else None)
            return found
    return {}


def si_factor(unit: str) -> tuple[float, Dimensionality]:
    """SI factor and dimensionality of a unit text; raises UnitError if there is no such unit."""
    known = _kept()
    if unit not in known:
        known[unit] = _si_factor(unit)
    return known[unit]


def _si_factor(unit: str) -> tuple[float, Dimensionality]:
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
    units = registry()
    try:
        quantity = units.Quantity(1.0) * (units.parse_expression(text) if text else 1.0)
        base = quantity.to_root_units()
    except (  # raised by pint for malformed products such as `N(` or `m**/s`
        ArithmeticError,
        AssertionError,
        AttributeError,
        IndexError,
        SyntaxError,
        TokenError,
        TypeError,
        ValueError,
    ):
        raise UnitError(f'"{" ".join(unit.split())}" is not a unit') from None
    return tidy(float(base.magnitude)), tuple(sorted(base.dimensionality.items()))


def tidy(value: float) -> float:
    """Remove the rounding error of a conversion: the value rounded to 12 digits, if that is within 4e-16 of it."""
    short = float(f"{value:.12g}")
    return short if abs(short - value) <= 4e-16 * abs(value) else value


@cache
def short_names() -> tuple[str, ...]:
    """Short names, names without a prefix first."""
    return (*PREFIXED, *PLAIN, *(prefix + unit for unit in PREFIXED for prefix in PREFIXES if prefix))


@cache
def _known() -> frozenset[str]:
    return frozenset((*short_names(), *UNIT_NAMES))
