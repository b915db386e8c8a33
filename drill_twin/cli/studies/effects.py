# SPDX-License-Identifier: Apache-2.0
"""Command `drill-twin effects`: ablation study of a scene."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drill_twin.cli.options import JsonOption, ReplaceOption, SceneArgument, SetOption, WorkersOption, overrides

if TYPE_CHECKING:
    from rich.table import Table

    from drill_twin.studies.ablation import Ablation, Change
    from drill_twin.studies.ablation.compare import Quantity


def effects(
    scene: SceneArgument,
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
        typer.Option("--replicas", min=2, max=100, help="Runs per set of effects, with small random differences."),
    ] = 5,
    duration: Annotated[
        str, typer.Option("--duration", metavar="TIME", help='Simulated time, as "30 s"; a bare number is in s.')
    ] = "",
    change: SetOption = [],  # noqa: B006  typer makes a new list of it
    workers: WorkersOption = 2,
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="DIR", help="New folder of the result.", show_default="out/effects_SCENE"),
    ] = None,
    replace: ReplaceOption = False,
    json: JsonOption = False,
) -> None:
    """Leave out each effect of a scene in turn: cost and change of each, and the effects that the scene needs.

    Each set of effects is compiled once and then cached. Writes effects.json and effects.png.
    """
    from rich.progress import Progress

    from drill_twin.cli.folder import folder_name, new_folder, write_file
    from drill_twin.cli.show import err, print_json
    from drill_twin.cli.show import out as stdout
    from drill_twin.scene import load_scene
    from drill_twin.studies.ablation import ablate, groups
    from drill_twin.studies.json_io import json_text

    changes = overrides(change, duration=duration)
    described = load_scene(scene, overrides=changes)
    folder = out or Path("out") / f"effects_{folder_name(described.name)}"
    new_folder(folder, replace=replace)
    with Progress(console=err(), transient=True) as progress:
        task = progress.add_task("running", total=len(groups(tuple(described.effect_names))) + 2)

        def done(left_out: str) -> None:
            progress.update(task, advance=1, description=f"done without {left_out}")

        ablation = ablate(scene, changes, tolerance=tolerance, replicas=replicas, workers=workers, progress=done)
    write_file(folder / "effects.json", json_text(ablation.to_dict()))
    from drill_twin.studies.ablation.figure import draw

    draw(ablation, folder / "effects.png")
    if json:
        print_json(ablation.to_dict())
    else:
        stdout().print(_table(ablation))
        stdout().print(_verdict(ablation), markup=False, soft_wrap=True)
    err().print(f"{folder}: effects.json, effects.png", markup=False, soft_wrap=True)


def _table(ablation: Ablation) -> Table:
    from drill_twin.cli.show import grid
    from drill_twin.studies.ablation.compare import NAMES

    known = next(change.quantities for change in (*ablation.changes, ablation.reduced) if change.quantities)
    runs = ablation.replicas
    first = ("nothing", "", "", *(_value(key, known[key].before, known[key].runs_before, runs) for key in NAMES))
    title = f"{ablation.scene}, {runs} runs each; * = beyond the tolerance and beyond chance, ? = too few runs to tell"
    table = grid(
        ("left out", "step time", "run time", *NAMES.values()),
        [first, *(_row(change, runs) for change in ablation.changes)],
        title=title,
        right=(1, 2, 3, 4, 5, 6),
    )
    table.columns[0].no_wrap = True
    return table


def _row(change: Change, runs: int) -> tuple[str, ...]:
    from drill_twin.studies.ablation.compare import NAMES

    name = " + ".join(change.left_out)
    if change.failure:
        return (name, "", "", *("no run *" for _ in NAMES))
    prices = (f"{-(share or 0.0):+.0%}" for share in (change.iteration_share, change.cost_share))
    return (name, *prices, *(_cell(key, change.quantities[key], runs) for key in NAMES))


def _cell(key: str, quantity: Quantity, runs: int) -> str:
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
