# SPDX-License-Identifier: Apache-2.0
"""Assemblies or set-points beside each other: cases, the quantities in which they differ, and the page of both."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import NamedTuple

import numpy as np

from drill_twin.api.growth_limits import modes_under
from drill_twin.api.result import Result, read_bag
from drill_twin.api.rotordynamics import final_command
from drill_twin.api.scenes import load_scene
from drill_twin.api.simulation import Simulation
from drill_twin.api.torque_drag import statics
from drill_twin.core.arrays import Array, number_or_nan
from drill_twin.core.errors import ArgumentError, RunError, SceneError
from drill_twin.core.table import Column, Table
from drill_twin.core.units.system import UnitSystem
from drill_twin.dynamics.rotordynamics.modes import LATERAL
from drill_twin.dynamics.torque_drag.analysis import OperationLoads
from drill_twin.report.page import html_page, picture
from drill_twin.report.string_forces import bending_stress_at
from drill_twin.scene import Scene

_CHANGE = re.compile(r",\s*(?=[A-Za-z_][\w.]*=)")


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


def prepare(text: str, common: Mapping[str, str]) -> Scene | Result:
    """Read a case: the scene of `SCENE[,KEY=VALUE...]`, not yet run, or the result of a bag.

    Args:
        text: A scene with changes (`wob`, `rpm` or any key of a scene), or the folder or file of a bag.
        common: Changes of all cases that are run.

    Raises:
        ArgumentError: A change of a bag.
        SceneError: No such scene, or a change that does not fit.
        BagError: No bag of this package.
    """
    base, *changes = _CHANGE.split(text)
    own = dict(change.split("=", 1) for change in changes)
    path = Path(base)
    if path.is_dir() or path.suffix in {".mcap", ".db3"}:
        if own:
            raise ArgumentError(
                f"{text}: expected a bag without changes, found {', '.join(own)}; a run is over. Name its scene "
                "instead, or use drill-twin rerun"
            )
        return read_bag(path)
    return load_scene(base, {**common, **own})


def finish(text: str, what: Scene | Result, progress: Callable[[float], None] | None = None) -> Case:
    """Run a scene, if it is one, and find its loads in a balance.

    Raises:
        RunError: The run stops early.
    """
    result = what
    if isinstance(result, Scene):
        result = Simulation(result).run(progress=(lambda state: progress(state.time)) if progress else None)
    try:
        loads = statics(result.scene).operations[-1]
    except (RunError, SceneError):  # no balance, or nothing to balance: the run is compared alone
        loads = None
    return Case(text, result, loads, _critical(result.scene))


def _critical(scene: Scene) -> float:
    """Distance of the final rotation from the nearest critical speed about a balance that is stable, over it."""
    try:
        table = modes_under(scene, final_command(scene))
    except (RunError, SceneError):  # no balance, or no modes: the rest is compared
        return math.nan
    rotation = abs(table.balance.command.rotation)
    return (
        abs(table.nearest_critical() - rotation) / rotation if rotation and not table.growing.get(LATERAL) else math.nan
    )


NOTHING = 1e-9
"""Number that is zero but for rounding."""
REST = 0.05
"""Share of the mean speed below which the bit counts as at rest."""
POSES = 40
"""Shapes of the string, over the second half of the run, of which the largest bending stress is taken."""


class ComparedQuantity(NamedTuple):
    """Quantity in each case: numbers in SI, or words."""

    name: str
    unit: str
    values: tuple[float | str, ...]
    """NaN or an empty text where a case does not have it."""

    def differs(self, tolerance: float) -> bool:
        """True if a case differs from the first by more than a share of the larger one; words: at all."""
        first = self.values[0]
        return any(_differ(first, other, tolerance) for other in self.values[1:])

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


def _differ(one: float | str, other: float | str, tolerance: float) -> bool:
    if isinstance(one, str) or isinstance(other, str):
        return one != other
    if math.isnan(one) or math.isnan(other):
        return math.isnan(one) != math.isnan(other)
    larger = max(abs(one), abs(other))
    return larger > NOTHING and abs(one - other) > tolerance * larger


def quantities(cases: Sequence[Case]) -> list[ComparedQuantity]:
    """All compared quantities, the balance's quantities first; a quantity that no case has is left out."""
    rows = [dict(_of(case)) for case in cases]
    names = dict.fromkeys(key for row in rows for key in row)
    found = []
    for name, unit in names:
        known = next(row[name, unit] for row in rows if (name, unit) in row)
        missing: float | str = "" if isinstance(known, str) else math.nan
        found.append(ComparedQuantity(name, unit, tuple(row.get((name, unit), missing) for row in rows)))
    return [row for row in found if any(value == value and value != "" for value in row.values)]  # noqa: PLR0124  NaN


def _of(case: Case) -> Iterator[tuple[tuple[str, str], float | str]]:
    if (loads := case.loads) is not None:
        what, margins = f"balance, {loads.operation.name}: ", loads.margins
        yield (what + "hookload", "N"), loads.hookload
        yield (what + "surface torque", "N m"), loads.surface_torque
        yield (what + "neutral point from the bit", "m"), loads.neutral_point
        yield (what + "margin to sinusoidal buckling", "-"), margins[0] if math.isfinite(margins[0]) else math.nan
        yield (what + "yield margin", "-"), loads.yield_margin
        yield (what + "make-up margin", "-"), loads.make_up_margin
        for contact in loads.contacts:
            yield (f"{what}side force, {contact.name}", "N"), contact.force
    yield ("margin to the nearest critical speed of the assembly", "-"), case.critical
    yield from _run(case)


def _run(case: Case) -> Iterator[tuple[tuple[str, str], float | str]]:
    summary, rig = case.result.summary, case.result.rig
    half = rig.time >= 0.5 * (rig.time[0] + rig.time[-1]) if len(rig) else np.zeros(0, bool)
    yield ("motion that lasts", ""), summary["lasting_motion"] or ""
    yield ("onset of whirl", "s"), number_or_nan(summary["onset_s"])
    yield ("whirl frequency", "Hz"), number_or_nan(summary["whirl_frequency_hz"])
    yield ("whirl ratio", "-"), number_or_nan(summary["whirl_ratio"])
    for mark, radius in summary["max_radius_m"].items():
        yield (
            (f"largest radius, {mark}, of its clearance (above 100: into the wall)", "%"),
            100.0 * number_or_nan(radius) / summary["clearance_m"][mark],
        )
    yield ("bit at the end", ""), summary["bit"] or ""
    yield ("stick-slip index", "-"), number_or_nan(summary["stick_slip_index"])
    for way in ("lateral", "axial"):
        found = [sizes[f"{way}_rms_m_s2"] for sizes in summary["acceleration"].values()]
        yield (f"{way} acceleration, rms", "m/s^2"), max(found, default=math.nan)
    damage = [section["damage"] for section in (summary["fatigue"] or {}).values()]
    yield ("fatigue damage", "-"), max(damage, default=math.nan)
    yield ("rate of penetration", "m/s"), number_or_nan(summary["rate_of_penetration_m_s"])
    yield ("specific energy", "Pa"), number_or_nan(summary["specific_energy_pa"])
    if half.any():
        speed = rig.bit_speed[half]
        yield ("speed of the bit, least", "rad/s"), _least(speed)
        yield ("speed of the bit, largest", "rad/s"), -_least(-speed)
        yield ("time of the bit at rest", "%"), 100.0 * float(np.mean(np.abs(speed) < REST * abs(np.nanmean(speed))))
        for name, unit, values in (
            ("torque of the top drive", "N m", rig.top_drive_torque[half]), ("weight on bit", "N", rig.bit_force[half]),
            ("hookload", "N", rig.hookload[half]),
        ):  # fmt: skip
            yield (f"{name}, mean", unit), float(np.nanmean(values))
            yield (f"{name}, swing", unit), -_least(-values) - _least(values)
    if (force := case.result.wall_force).size:
        yield ("largest force of the wall at a mark", "N"), float(np.nanmax(force[len(force) // 2 :]))
    if poses := len(case.result.recording.poses):
        chosen = np.linspace(poses // 2, poses - 1, POSES).astype(np.int64)
        if (stress := bending_stress_at(case.result.recording, chosen)) is not None:
            yield ("largest bending stress", "Pa"), float(stress.max())


def _least(values: Array) -> float:
    known = values[np.isfinite(values)]
    return float(known.min()) if known.size else math.nan


def page(
    names: Sequence[str], found: Sequence[ComparedQuantity], tolerance: float, notes: Sequence[str], figure: Path,
    units: UnitSystem, verdict: Sequence[str], costs: Table,
) -> str:  # fmt: skip
    """HTML text; rows that differ are first.

    Args:
        names: Of the cases.
        found: Quantities.
        tolerance: Share from which they differ.
        notes: Sentences above the table.
        figure: PNG file.
        units: Of the tables.
        verdict: Sentences above all.
        costs: Table below them.
    """
    ordered = sorted(found, key=lambda row: not row.differs(tolerance))
    differing = sum(row.differs(tolerance) for row in ordered)
    parts = (("What differs", ordered[:differing]), ("What does not", ordered[differing:]))
    tables = "".join(
        f"<h2>{title}</h2><section>{_table(len(names), rows, units)}</section>" for title, rows in parts if rows
    )
    legend = "<br>".join(escape(f"{chr(ord('A') + case)}: {name}") for case, name in enumerate(names))
    return html_page(
        "drill_twin: comparison",
        f"<h1>Comparison</h1><p>{legend}</p>"
        f'<p class="lead">Differences of more than {100.0 * tolerance:g} % first; numbers of runs are of their second '
        "half.</p>"
        f"{''.join(f'<p>{escape(note)}</p>' for note in notes)}"
        f"<h2>Verdict</h2><section>{''.join(f'<p><b>{escape(said)}</b></p>' for said in verdict)}"
        f"<p>{escape(costs.title)}</p>{costs.html()}</section>"
        f"{tables}<h2>Over time</h2><section>{picture(figure, 'the runs over time')}</section>",
    )


def _table(cases: int, rows: Sequence[ComparedQuantity], units: UnitSystem) -> str:
    cells = (
        (Column(row.name, units.in_unit(row.unit)[1]).title, *(row.text(case, units) for case in range(cases)))
        for row in rows
    )
    return Table(("", *(chr(ord("A") + case) for case in range(cases))), cells, right=range(1, 1 + cases)).html()
