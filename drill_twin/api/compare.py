# SPDX-License-Identifier: Apache-2.0
"""Assemblies or set-points beside each other: cases, the quantities in which they differ, and the page of both."""

import math
import re
from collections.abc import Callable, Mapping, Sequence
from html import escape
from pathlib import Path

from drill_twin.api.compared_quantities import Case, ComparedQuantity
from drill_twin.api.result import Result, read_bag
from drill_twin.api.rotordynamics import final_command, modes_under
from drill_twin.api.scenes import load_scene
from drill_twin.api.simulation import Simulation
from drill_twin.api.torque_drag import statics
from drill_twin.core.errors import ArgumentError, RunError, SceneError
from drill_twin.core.table import Table
from drill_twin.core.units.system import UnitSystem
from drill_twin.dynamics.rotordynamics.modes import LATERAL
from drill_twin.report.page import html_page, picture
from drill_twin.scene import Scene
from drill_twin.scene.load import override

SETTLED = 4.0 / 3.0
"""Least duration over the end of the ramps, so that a quarter of the run follows (`report.quantities.settled_from`)."""
_CHANGE = re.compile(r",\s*(?=[A-Za-z_][\w.]*=)")


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


def settled(what: Sequence[Scene | Result]) -> tuple[list[Scene | Result], list[str]]:
    """Prolong scenes whose set-points still move near the end of the run; and a sentence where one does.

    Raises:
        ArgumentError: The run of a bag ends so.
    """
    ends, lengths = [], []
    for one in what:
        rig = one.scene.rig if isinstance(one, Result) else one.rig
        ramps = [point for point in (rig.weight_on_bit, rig.rotation) if point.shape in {"step", "ramp"}]
        ends.append(max((point.start + point.duration for point in ramps if not rig.holds_values), default=0.0))
        lengths.append(one.recording.duration if isinstance(one, Result) else rig.duration)
        if isinstance(one, Result) and lengths[-1] < SETTLED * ends[-1]:
            raise ArgumentError(
                f"{one.recording.path}: expected a run that goes on after its set-points have settled "
                f"at {ends[-1]:g} s, found one of {lengths[-1]:.4g} s; record a longer run"
            )
    short = [end for end, length in zip(ends, lengths, strict=True) if length < SETTLED * end]
    if not short:
        return list(what), []
    least = 2.0 * max(short)
    longer: list[Scene | Result] = [
        override(one, {"rig.duration": max(least, one.rig.duration)}) if isinstance(one, Scene) else one for one in what
    ]
    return longer, [f"Set-points settle at {max(short):g} s: the runs were prolonged to {least:g} s."]


def finish(text: str, what: Scene | Result, progress: Callable[[float], None] | None = None) -> Case:
    """Run a scene, if it is one, and find its loads in a balance.

    Raises:
        RunError: The run stops early.
    """
    result = what
    if isinstance(result, Scene):
        result = Simulation(result).run(progress=(lambda state: progress(state.time)) if progress else None)
    try:
        found = statics(result.scene)
        failed = found.notes.keys() - {one.operation.name for one in found.operations}
        loads = None if failed and found.operations[-1].operation.name != "drill" else found.operations[-1]
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
        f"<h2>{title}</h2><section>{table(len(names), rows, units).html()}</section>" for title, rows in parts if rows
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


def table(cases: int, rows: Sequence[ComparedQuantity], units: UnitSystem) -> Table:
    """Quantities of the cases, a row each."""
    heads = ("", *(chr(ord("A") + case) for case in range(cases)))
    return Table(heads, (row.cells(units) for row in rows), right=range(1, 1 + cases))
