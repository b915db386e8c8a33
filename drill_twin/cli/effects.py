# SPDX-License-Identifier: Apache-2.0
"""Command `drill-twin effects`: ablation study of a scene."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drill_twin.cli import options
from drill_twin.cli.emit import emit, folder_name
from drill_twin.cli.show import shown_progress
from drill_twin.core.files.output import make_folder
from drill_twin.core.table import Table

if TYPE_CHECKING:
    from drill_twin.studies.accuracy.ablation import Ablation, Change
    from drill_twin.studies.accuracy.errors import AblationQuantity


def effects(
    scene: options.SceneArgument,
    tolerance: Annotated[
        float,
        typer.Option(
            "--tolerance",
            min=0.001,
            max=1.0,
            help="Smallest relevant change: relative for onset time and whirl frequency, absolute for mean orbit "
            "radius over clearance and for contact fraction.",
        ),
    ] = 0.05,
    replicas: Annotated[
        int,
        typer.Option(
            "--replicas", min=2, max=100, help="Number of runs for each set of effects, with small random differences."
        ),
    ] = 5,
    duration: options.DurationOption = "",
    change: options.SetOption = [],  # noqa: B006  typer makes a new list of it
    workers: options.WorkersOption = 0,
    out: Annotated[
        Path | None, options.folder_option("Folder of the result; an interrupted study continues.", "out/effects_SCENE")
    ] = None,
    json: options.JsonOption = False,
) -> None:
    """Leave out each effect of a scene in turn: its cost, what it changes, and the effects that the scene needs.

    Each set of effects is compiled once and then cached. An interrupted study continues. Writes effects.json and
    effects.png.
    """
    from drill_twin.scene import load_scene
    from drill_twin.studies.accuracy.ablation import ablate, groups
    from drill_twin.studies.accuracy.figures import ablation_figure

    changes = options.overrides(change, duration=duration)
    described = load_scene(scene, overrides=changes)
    folder = out or Path("out") / f"effects_{folder_name(described.name)}"
    make_folder(folder / "runs")
    runs = replicas * (len(groups(tuple(described.effect_names))) + 2)
    with shown_progress("running", runs, kept=f"the same command goes on from {folder / 'runs'}") as bar:
        ablation = ablate(
            scene, changes, folder / "runs", tolerance=tolerance, replicas=replicas, workers=workers,
            progress=lambda left_out: bar.step(f"done without {left_out}"),
        )  # fmt: skip
    data = asdict(ablation)
    files = {"effects.json": data, "effects.png": lambda: ablation_figure(ablation)}
    emit(data, (part(ablation) for part in (_table, _verdict)), json=json, folder=folder, files=files, also=["runs"])


def _table(ablation: Ablation) -> Table:
    from drill_twin.studies.accuracy.errors import NAMES

    known = next(change.quantities for change in (*ablation.changes, ablation.reduced) if change.quantities)
    runs = ablation.replicas
    first = ("nothing", "", "", *(_value(key, known[key].before, known[key].runs_before, runs) for key in NAMES))
    title = f"{ablation.scene}, {runs} runs each; * = beyond the tolerance and beyond chance, ? = too few runs to tell"
    columns = ("left out", "step time", "run time", *NAMES.values())
    rows = [first, *(_row(change, runs) for change in ablation.changes)]
    return Table(columns, rows, title=title, right=range(1, len(columns)))


def _row(change: Change, runs: int) -> tuple[str, ...]:
    from drill_twin.studies.accuracy.errors import NAMES

    name = " + ".join(change.left_out)
    if change.failure:
        return (name, "", "", *("no run *" for _ in NAMES))
    prices = (f"{-(share or 0.0):+.0%}" for share in (change.iteration_share, change.cost_share))
    return (name, *prices, *(_cell(key, change.quantities[key], runs) for key in NAMES))


def _cell(key: str, quantity: AblationQuantity, runs: int) -> str:
    mark = " *" if quantity.matters else "  " if quantity.known else " ?"
    return _value(key, quantity.after, quantity.runs_after, runs) + mark


def _value(key: str, value: float | None, having: int, runs: int) -> str:
    unit = {"onset_s": " s", "whirl_frequency_hz": " Hz"}.get(key, "")
    return "none" if value is None else f"{value:.3g}{unit}" + (f" ({having} of {runs})" if having < runs else "")


def _verdict(ablation: Ablation) -> str:
    not_needed = [key for key in ablation.effects if key not in ablation.kept]
    share = ablation.reduced.cost_share or 0.0
    saved = f", which saves {share:.0%} of the run time" if not_needed else ""
    failures = "".join(
        f"There is no run without {' + '.join(change.left_out)}: {change.failure}.\n"
        for change in ablation.changes
        if change.failure
    )
    untold = [
        change.left_out[0] for change in ablation.changes if change.unknown and change.left_out[0] in ablation.kept
    ]
    unknown = f"Kept because {ablation.replicas} runs do not tell: {', '.join(untold)}.\n" if untold else ""
    return (
        f"{failures}At a tolerance of {ablation.tolerance:.1%} this scene calls for: {', '.join(ablation.kept)}.\n"
        f"{unknown}No change is seen without: {', '.join(not_needed) or 'none'}{saved}."
    )
