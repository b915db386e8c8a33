# SPDX-License-Identifier: Apache-2.0
"""Command `drill-twin whirl`: steady whirl of a scene and its stability."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from drill_twin.cli import options
from drill_twin.cli.emit import emit
from drill_twin.cli.show import shown_progress
from drill_twin.core.table import Table

if TYPE_CHECKING:
    from drill_twin.dynamics.rotordynamics.steady.branches import Branch
    from drill_twin.dynamics.rotordynamics.steady.whirl_state import WhirlState
    from drill_twin.scene import Scene

_STABLE = {"stable": "yes", "unstable": "no", "not determined": "?"}


def whirl(
    scene: options.SceneArgument,
    wob: options.WeightOption = "",
    rpm: options.RpmOption = "",
    change: options.SetOption = [],  # noqa: B006  typer makes a new list of it
    without: options.WithoutOption = [],  # noqa: B006
    starts: Annotated[
        int,
        typer.Option(
            "--starts",
            metavar="N",
            min=0,
            max=100,
            help="Number of random shapes, besides four modes, from which the search begins.",
        ),
    ] = 2,
    over: Annotated[
        str,
        typer.Option(
            "--over",
            metavar="KEY=LO..HI",
            help='Follow each state over a range of "wob=5..80 N", "rpm=60..480" or another number of the scene.',
        ),
    ] = "",
    out: Annotated[Path | None, options.folder_option("Write the results and their figures to this folder.")] = None,
    units: options.UnitsOption = "",
    json: options.JsonOption = False,
) -> None:
    """Find the steady whirls that can exist at the final set-points: frequency, ratio to the rotation, stability.

    In the frame that turns with it a steady whirl is an equilibrium, found by Newton's method from several shapes and
    whirl speeds: first without `stretch` and `torsion`, then with them where the scene has them. Each state is computed
    on finer meshes too, which tell how much of its growth is the mesh's. States hold for the string without bow and
    eccentricity, which modulate them.
    """
    from drill_twin.api import rotordynamics
    from drill_twin.studies.whirl_states import state_data, states_figure

    own = rotordynamics.steady_scene(scene, options.overrides(change, wob=wob, rpm=rpm, units=units), without)
    if over:
        _follow(own, over, starts, out, json=json)
        return
    with shown_progress("searching"):
        found = rotordynamics.whirl_states(own, random_starts=starts)
        modulations, locked = rotordynamics.imperfect_states(own, found)
    sizes = [*(one.size for one in modulations), *(None for _ in locked)]
    data = [state_data(state, size) for state, size in zip((*found, *locked), sizes, strict=True)]
    shares = [None if size is None else size / own.least_clearance for size in sizes]
    files = {"states.json": data, **({"states.png": lambda: states_figure(found, own)} if found else {})}
    emit(data, _shown(own, found, locked, shares), json=json, folder=out, files=files)


def _shown(
    own: Scene, found: Sequence[WhirlState], locked: Sequence[WhirlState], shares: Sequence[float | None]
) -> Iterator[Table | str]:
    if states := (*found, *locked):
        yield _table(states, shares, own)
    for state in states:
        if state.lost_at:
            where = f"{state.kind} at {state.frequency:+.4f} Hz: not found again on {state.lost_at} elements"
            yield f"{where}, so it may be of the mesh of {state.elements}"
    if not found:
        yield f"{own.name}: {_none_found(own)}"


def _none_found(scene: Scene) -> str:
    """Sentence where the search finds no steady whirl."""
    from drill_twin.dynamics.rotordynamics.equations import EquationsOfMotion
    from drill_twin.dynamics.rotordynamics.steady.whirl_states import rolling_ratios

    ratios = rolling_ratios(EquationsOfMotion(scene).model)
    text = "no steady whirl found at these set-points; more first shapes with --starts, or a run in time"
    if len(ratios) == 1:
        return text
    rolling = " and ".join(f"{ratio:.3g}" for ratio in ratios)
    return f"{text}. Its parts roll on the wall at {rolling} of the rotation, so it cannot roll as a whole"


def _table(states: Sequence[WhirlState], modulated: Sequence[float | None], scene: Scene) -> Table:
    command = states[0].whirl.command
    rows = [
        (
            state.kind, f"{state.frequency:+.3f}", f"{state.ratio:+.3f}", _STABLE[state.verdict],
            f"{state.growth:+.3g}", "?" if math.isnan(state.growth_change) else f"{state.growth_change:.1g}",
            f"{state.growth_frequency:.3g}", f"{100.0 * state.touching:.0f}%",
            "" if share is None else f"{100.0 * share:.1g}%",
        )
        for state, share in zip(states, modulated, strict=True)
    ]  # fmt: skip
    finest = sorted({state.elements for state in states})
    title = (
        f"{scene.name}: steady whirl at {scene.unit_system.set_point(command.weight_on_bit, command.rotation)}. "
        "Frequency in Hz, ratio to the rotation; growth of the fastest disturbance in 1/s, +- its larger change on the "
        "last two meshes, each twice as fine as the one before (stable ?: its sign is not determined), its "
        "frequency in the turning frame in Hz; share of the length on the wall; modulation by bow "
        f"and eccentricity to first order, over the clearance. On {' or '.join(map(str, finest))} elements. Locked: "
        "the bent string turns with the rotation."
    )
    columns = ("whirl", "Hz", "ratio", "stable", "growth", "+-", "at", "wall", "mod.")
    return Table(columns, rows, title=title, right=(1, 2, 4, 5, 6, 7, 8))


def _follow(scene: Scene, over: str, starts: int, out: Path | None, *, json: bool) -> None:
    """Branches over a number: table or JSON, and the figure."""
    from drill_twin.api import rotordynamics
    from drill_twin.studies.whirl_states import branch_data, branches_figure, shown_parameter

    ((key, span),) = options.ranges_of("--over", [over]).items()
    with shown_progress("following"):
        found = rotordynamics.branches(scene, over=key, span=span, random_starts=starts)
    label, unit = shown_parameter(key, scene.unit_system)
    data = {"branches": [branch_data(one) for one in found]}
    files: dict[str, Any] = {"branches.json": data}
    if found:
        files["branches.png"] = lambda: branches_figure(found, scene.name, scene.unit_system)
    emit(data, _shown_branches(scene, found, label, unit), json=json, folder=out, files=files)


def _shown_branches(scene: Scene, found: Sequence[Branch], label: str, unit: float) -> Iterator[Table | str]:
    from drill_twin.dynamics.discretisation.resolution import resolution_of

    rows = [
        (
            str(number + 1), f"{one.values.min() / unit:.4g} to {one.values.max() / unit:.4g}",
            f"{min(s.ratio for s in one.states):+.3f} to {max(s.ratio for s in one.states):+.3f}",
            f"{100.0 * sum(s.is_stable for s in one.states) / len(one.states):.0f} %",
            ", ".join(f"{one.values[k] / unit:.4g}" for k in one.folds) or "none",
            ", ".join(f"{one.values[k] / unit:.4g}" for k in one.hopf) or "none", "; ".join(one.ends),
        )
        for number, one in enumerate(found)
    ]  # fmt: skip
    columns = ("branch", label, "ratio", "points stable", "folds", "Hopf points", "ends (low, high side)")
    yield Table(columns, rows, title=f"{scene.name}: branches of steady whirl")
    yield (
        f"Branches are computed on a mesh of {resolution_of(scene)[0]} elements, the run's; without --over, the "
        "states at one set-point show how far finer meshes move them."
    )
