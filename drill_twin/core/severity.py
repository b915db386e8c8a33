# SPDX-License-Identifier: Apache-2.0
"""Severity of a motion by what it does to the string: one scale for reports, maps, comparisons, alarms and topics.

A quantity (`Bounds`) has the grade of the highest bound that it reaches; a motion has the grade of its worst quantity.
The bounds are parameters: a scene that has a block `severity` replaces them.
"""

import math
from bisect import bisect_right
from collections.abc import Iterable, Mapping
from enum import IntEnum
from typing import Any, NamedTuple

from drill_twin.core.units.dimension import GRAVITY
from drill_twin.core.units.system import QUANTITIES, UnitSystem

OF_THIS_PROGRAM = "of this program, not of a vendor"
"""Source of the bounds that a scene does not give."""
LAB = "lab"
"""System of units of a bench, for which the bounds of downhole tools are not meant."""


class Grade(IntEnum):
    """Grade of a quantity or of a motion."""

    NONE = 0
    LOW = 1
    MEDIUM = 2
    HIGH = 3
    SEVERE = 4

    @property
    def word(self) -> str:
        """Name in text."""
        return self.name.lower()


def _in_g(*values: float) -> tuple[float, ...]:
    return tuple(GRAVITY * value for value in values)


class Bounds(NamedTuple):
    """Values at which the grades low, medium, high and severe begin, by quantity, in SI."""

    lateral_rms: tuple[float, ...] = _in_g(0.5, 2.0, 5.0, 8.0)
    """Lateral acceleration of the centre line, root mean square [m/s^2]."""
    lateral_peak: tuple[float, ...] = _in_g(10.0, 25.0, 50.0, 100.0)
    """Lateral acceleration of the centre line, largest [m/s^2]."""
    axial_rms: tuple[float, ...] = _in_g(0.5, 2.0, 5.0, 8.0)
    """Axial acceleration, root mean square [m/s^2]."""
    axial_peak: tuple[float, ...] = _in_g(10.0, 25.0, 50.0, 100.0)
    """Axial acceleration, largest [m/s^2]."""
    bending_stress: tuple[float, ...] = (35e6, 70e6, 140e6, 210e6)
    """Half of the range of bending stress that a fibre of steel goes through [Pa]; 140 MPa are 20,000 psi, the
    endurance of drill pipe in bending without tension (Lubinski 1961)."""
    wall_force: tuple[float, ...] = (2.2e3, 4.4e3, 8.9e3, 17.8e3)
    """Mean force of the wall on the length of a joint, 30 ft [N]; 8.9 kN are 2000 lbf, a limit of tool joints against
    the wear of casing. Collars in an inclined hole exceed it by their weight: reports print the force without grade
    unless a scene gives own bounds."""
    stick_slip: tuple[float, ...] = (0.25, 0.5, 1.0, 1.2)
    """Stick-slip index [-]; 0.5 and 1 by `whirl.criteria.BitMotion`, and beyond 1 the bit may turn backwards."""


DEFAULT = Bounds()
"""Bounds of a scene without a block `severity`, and of a record without a scene."""
UNITS = dict(zip(Bounds._fields, ("m/s^2", "m/s^2", "m/s^2", "m/s^2", "Pa", "N", "-"), strict=True))
"""SI unit of each quantity."""
WORDS = dict(
    zip(
        Bounds._fields,
        (
            "lateral acceleration, rms", "lateral acceleration, peak", "axial acceleration, rms",
            "axial acceleration, peak", "bending stress", "wall force on 30 ft", "stick-slip index",
        ),
        strict=True,
    )
)  # fmt: skip
"""Each quantity in words."""


class Severity(NamedTuple):
    """Grade of a motion, and the quantity that decides it."""

    grade: Grade
    quantity: str
    """Field of `Bounds`."""
    value: float
    """Value of the quantity in SI."""
    place: str = ""
    """Mark or part with this value; empty where the quantity is of the whole string."""

    @property
    def entry(self) -> dict[str, Any]:
        """Entry of a summary: `grade`, `word`, `quantity`, `value` [SI] and `place`, in plain types."""
        return {**self._asdict(), "grade": int(self.grade), "word": self.grade.word}


def told(entry: Mapping[str, Any] | None, units: UnitSystem) -> str:
    """Severity of a summary as text, with what decided it: `medium: lateral acceleration 2.6 g rms at mark_2`."""
    if entry is None:
        return "unknown"
    name, _, kind = WORDS[entry["quantity"]].partition(", ")
    value = value_text(entry["quantity"], entry["value"], units)
    decided = " ".join(filter(None, (name, value, kind, entry["place"] and f"at {entry['place']}")))
    word = f"{entry['word']}{' of what is known' if entry.get('unknown') else ''}"
    why = f" ({entry['why']})" if entry.get("why") else ""
    return "; ".join(filter(None, (f"{word}: {decided}{why}", entry.get("unknown"))))


def whose_bounds(source: str | None, units: str) -> str:
    """Text on where the bounds come from, for a page or a table: the source of the scene's, by its system of units."""
    return source or f"{OF_THIS_PROGRAM}{', for tools of the field, not of a bench' * (units == LAB)}"


def value_text(quantity: str, value: float | None, units: UnitSystem) -> str:
    """Value in SI as text in the reader's unit, two digits or all before the point; an index has three."""
    if value is None:
        return "unknown"
    shown = QUANTITIES.get(UNITS[quantity])
    if not shown:
        return f"{value:.3g}"
    number = float(units.show(value, shown))
    return f"{number:{'.0f' if abs(number) >= 99.5 else '.2g'}} {getattr(units, shown)}"


def grade(quantity: str, value: float, bounds: Bounds = DEFAULT) -> Grade | None:
    """Grade of the value of a quantity in SI; None for NaN."""
    return None if math.isnan(value) else Grade(bisect_right(getattr(bounds, quantity), value))


def _top(known: Iterable[Severity], bounds: Bounds) -> Severity | None:
    """Severity that decides: of the highest grade, then nearest to, or furthest beyond, its severe bound."""
    return max(known, default=None, key=lambda one: (one.grade, one.value / getattr(bounds, one.quantity)[-1]))


def worst_row(rows: Mapping[str, Mapping[str, Any]], bounds: Bounds) -> dict[str, Any] | None:
    """Entry of the row that decides, with its `why`, of rows of a summary by quantity; None where none is graded.

    `unknown` says that lateral acceleration is not known, where a row says why.
    """
    known = [
        Severity(Grade(row["grade"]), quantity, math.inf if row["value"] is None else row["value"], row["place"])
        for quantity, row in rows.items()
        if row["grade"] is not None
    ]
    top = _top(known, bounds)
    side = rows.get("lateral_rms", {"grade": 0})
    unknown = "" if side["grade"] is not None else f"{WORDS['lateral_rms'].partition(',')[0]} unknown ({side['why']})"
    return top and {**top.entry, "why": rows[top.quantity].get("why", ""), "unknown": unknown}


def worst(found: Iterable[tuple[str, float, str]], bounds: Bounds = DEFAULT) -> Severity | None:
    """Severity of a motion, from its quantities, values in SI and places; None where no value is known."""
    known = ((grade(quantity, value, bounds), quantity, value, place) for quantity, value, place in found)
    return _top(
        (Severity(at, quantity, value, place) for at, quantity, value, place in known if at is not None), bounds
    )
