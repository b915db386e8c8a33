# SPDX-License-Identifier: Apache-2.0
"""Quantities in which cases are compared, each with the difference from which it matters."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from drill_twin.api.result import Result
from drill_twin.core.arrays import Array, number_or_nan
from drill_twin.core.severity import DEFAULT, UNITS, WORDS, Bounds
from drill_twin.core.table import Column
from drill_twin.core.units.system import UnitSystem
from drill_twin.dynamics.torque_drag.analysis import OperationLoads
from drill_twin.whirl.criteria import STANDSTILL

NOTHING = 1e-9
"""Number that is zero but for rounding."""
QUARTER = 0.25
"""Share of the bound of the grade low below which a difference of a graded quantity does not matter; chosen."""
NEAR, SHARE = 1.0, 0.02
"""Largest distance of two places that are one [m], and the same over the length of the string; chosen."""
BIT_FORCE = "side force at the bit, + build, - drop"


@dataclass(frozen=True, eq=False)
class Case:
    """A case: its run, and its loads in a balance of forces."""

    name: str
    result: Result
    loads: OperationLoads | None
    """Loads of the last operation of the rig, which is drilling where the scene drills; None if there is no balance."""
    critical: float = math.nan
    """Distance of the final rotation from the nearest critical speed (of a long string: of its collars), as a share of
    it; NaN where it is not known."""

    @property
    def bounds(self) -> Bounds:
        """Bounds of the grades of severity."""
        recording = self.result.recording
        return recording.scene.severity_bounds if recording.scene_known else DEFAULT


class Relevance(NamedTuple):
    """Meaning of a difference of a quantity."""

    sign: float
    """1 where more is worse, -1 where less is, 0 where neither is."""
    matters: float
    """Difference below which nothing matters [SI]; chosen, not measured. 0: the tolerance alone decides."""
    key: str = ""
    """Field of `core.severity.Bounds`; `matters` is then `QUARTER` of its bound low, which a scene may set."""
    enough: float = math.inf
    """Value from which more is no better [SI]; chosen, not measured."""


RELEVANCE = {
    **{WORDS[key]: Relevance(1.0, 0.0, key) for key in WORDS},
    "largest side force of a stabiliser": Relevance(1.0, 0.0, "wall_force"),
    "fatigue damage": Relevance(1.0, 0.0),
    **{name: Relevance(-1.0, 0.1, enough=2.0)
       for name in ("margin to sinusoidal buckling", "yield margin", "make-up margin")},
    "margin to the nearest critical speed of the assembly": Relevance(-1.0, 0.05, enough=0.3),
    "specific energy": Relevance(1.0, 5e6), "rate of penetration": Relevance(-1.0, 1.0 / 3600.0),
    BIT_FORCE: Relevance(0.0, 220.0),
}  # fmt: skip
"""Relevance by the end of a quantity's name. Margins of a tenth, where one is below 2, 5 % of a critical speed within
30 % of it, 5 MPa of specific energy, 1 m/h, 220 N (50 lbf) at the bit: chosen."""


class ComparedQuantity(NamedTuple):
    """Quantity in each case: numbers in SI, or words."""

    name: str
    unit: str
    values: tuple[float | str, ...]
    """NaN or an empty text where a case does not have it."""
    matters: float = 0.0
    """Difference below which nothing matters [SI]."""
    enough: float = math.inf
    """Value from which more is no better [SI]."""

    def differs(self, tolerance: float) -> bool:
        """True if a case differs from the first by what matters and a share of the larger one; words: at all."""
        first, *others = (one if isinstance(one, str) else min(one, self.enough) for one in self.values)
        return any(_differ(first, other, tolerance, self.matters) for other in others)

    def cells(self, units: UnitSystem) -> tuple[str, ...]:
        """Name with unit, and the value of each case as text."""
        title = Column(self.name, units.in_unit(self.unit)[1]).title
        return (title, *(self.text(case, units) for case in range(len(self.values))))

    def text(self, case: int, units: UnitSystem) -> str:
        """Value as text in the units of the reader, with its difference from the first case."""
        value, first = self.values[case], self.values[0]
        if isinstance(value, str) or isinstance(first, str):
            return str(value) or "none"
        if not math.isfinite(value):
            return "none"
        shown = f"{units.in_unit(self.unit)[0] * value:.4g}"
        if case == 0 or not math.isfinite(first) or first == 0.0:
            return shown
        return f"{shown} ({100.0 * (value - first) / abs(first):+.0f} %)"


def _differ(one: float | str, other: float | str, tolerance: float, matters: float) -> bool:
    if isinstance(one, str) or isinstance(other, str):
        return one != other
    if math.isnan(one) or math.isnan(other):
        return math.isnan(one) != math.isnan(other)
    larger = max(abs(one), abs(other))
    return larger > NOTHING and abs(one - other) > max(tolerance * larger, matters)


def quantities(cases: Sequence[Case]) -> list[ComparedQuantity]:
    """All compared quantities, the balance's quantities first; a quantity that no case has is left out."""
    places: list[tuple[str, str, float]] = []
    rows = [dict(_of(case, places)) for case in cases]
    names = dict.fromkeys(key for row in rows for key in row)
    found = []
    for name, unit in names:
        known = next(row[name, unit] for row in rows if (name, unit) in row)
        missing: float | str = "" if isinstance(known, str) else math.nan
        values = tuple(row.get((name, unit), missing) for row in rows)
        found.append(ComparedQuantity(name, unit, values, *matters(name, cases[0])))
    return [row for row in found if any(value == value and value != "" for value in row.values)]  # noqa: PLR0124  NaN


def matters(name: str, case: Case) -> tuple[float, float]:
    """Difference of a quantity below which nothing matters and value from which more is no better [SI], of a case."""
    what = next((known for end, known in RELEVANCE.items() if name.endswith(end)), Relevance(0.0, 0.0))
    of_bound = what.key == "wall_force" or graded(what.key, case)  # a force is one on collars, too; a stress is not
    return QUARTER * float(getattr(case.bounds, what.key)[0]) if of_bound else what.matters, what.enough


def graded(key: str, case: Case) -> bool:
    """True where the bounds of a quantity of severity hold for a case; False without a quantity."""
    return bool(key) and case.result.summary["severity_by_quantity"].get(key, {}).get("grade", 0) is not None


def _at(places: list[tuple[str, str, float]], part: str, name: str, place: float, case: Case) -> str:
    """Name of a part and its place; of a part that another case has at the same place, the name there."""
    near = min(NEAR, SHARE * case.result.scene.length)
    for kind, label, at in places:
        if kind == part and abs(at - place) <= near:
            return label
    label = f"{name}, {case.result.recording.units.text(place, 'length')} from the bit"
    places.append((part, label, place))
    return label


def _of(case: Case, places: list[tuple[str, str, float]]) -> Iterator[tuple[tuple[str, str], float | str]]:
    if (loads := case.loads) is not None:
        what, margins = f"balance, {loads.operation.name}: ", loads.margins
        yield (what + "hookload", "N"), loads.hookload
        yield (what + "surface torque", "N m"), _sense(case) * loads.surface_torque
        yield (what + "neutral point from the bit", "m"), loads.neutral_point
        yield (what + "margin to sinusoidal buckling", "-"), margins[0] if math.isfinite(margins[0]) else math.nan
        yield (what + "yield margin", "-"), loads.yield_margin
        yield (what + "make-up margin", "-"), loads.make_up_margin
        bit, *blades = loads.contacts
        yield (what + BIT_FORCE, "N"), bit.build
        for contact in blades:
            where = _at(places, "blades", contact.name, contact.distance_from_bit, case)
            yield (f"{what}side force, {where}", "N"), contact.force
        largest = max((contact.force for contact in blades), default=math.nan)
        yield (what + "largest side force of a stabiliser", "N"), largest
    yield ("margin to the nearest critical speed of the assembly", "-"), case.critical
    yield from _run(case, places)


def _run(case: Case, places: list[tuple[str, str, float]]) -> Iterator[tuple[tuple[str, str], float | str]]:
    summary, rig = case.result.summary, case.result.rig
    late = rig.time >= summary["settled_s"]
    yield ("motion that lasts", ""), summary["lasting_motion"] or ""
    yield ("onset of whirl", "s"), number_or_nan(summary["onset_s"])
    yield ("whirl frequency", "Hz"), number_or_nan(summary["whirl_frequency_hz"])
    yield ("whirl ratio", "-"), number_or_nan(summary["whirl_ratio"])
    for mark in case.result.recording.places:
        where = _at(places, f"mark {mark.name}", mark.name, mark.distance_from_bit, case)
        radius = number_or_nan(summary["max_radius_m"].get(mark.name))
        share = 100.0 * radius / mark.clearance
        yield (f"largest radius, {where}, of its clearance (above 100: into the wall)", "%"), share
    yield ("bit at the end", ""), summary["bit"] or ""
    worst = summary["severity"]
    yield ("severity", ""), worst["word"] if worst else ""
    for key, row in summary["severity_by_quantity"].items():
        yield (WORDS[key], UNITS[key]), number_or_nan(row["value"])
    damage = [section["damage"] for section in (summary["fatigue"] or {}).values()]
    yield ("fatigue damage", "-"), max(damage, default=math.nan)
    yield ("rate of penetration", "m/s"), number_or_nan(summary["rate_of_penetration_m_s"])
    yield ("specific energy", "Pa"), number_or_nan(summary["specific_energy_pa"])
    speed = _sense(case) * _known(rig.bit_speed[late])
    if speed.size:
        yield ("speed of the bit, least", "rad/s"), float(speed.min())
        yield ("speed of the bit, largest", "rad/s"), float(speed.max())
        at_rest = np.abs(speed) < STANDSTILL * abs(speed.mean())
        yield ("time of the bit at rest", "%"), 100.0 * float(at_rest.mean())
    for name, unit, values in (
        ("torque of the top drive", "N m", _sense(case) * rig.top_drive_torque), ("weight on bit", "N", rig.bit_force),
        ("hookload", "N", rig.hookload),
    ):  # fmt: skip
        if (known := _known(values[late])).size:
            yield (f"{name}, mean", unit), float(known.mean())
            yield (f"{name}, swing", unit), float(np.ptp(known))


def _sense(case: Case) -> float:
    """Sign of the rotation: torque and speed are compared in its sense, as a mirrored run is the same run."""
    return -1.0 if case.result.scene.rig.rotation.value < 0.0 else 1.0


def _known(values: Array) -> Array:
    return values[np.isfinite(values)]
