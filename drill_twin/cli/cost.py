# SPDX-License-Identifier: Apache-2.0
"""Commands `drill-twin cost` and `effects`: what resolution and effects of a scene cost, and what they change."""

from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from drill_twin.cli import options
from drill_twin.cli.emit import emit, folder_name
from drill_twin.cli.show import shown_progress
from drill_twin.core.files.output import make_folder


def cost(
    scene: options.SceneArgument,
    duration: options.DurationOption = "",
    change: options.SetOption = [],  # noqa: B006  typer makes a new list of it
    replicas: Annotated[
        int,
        typer.Option(
            "--repeats", metavar="N", min=0, max=50, help="Number of repeats of the converged run, for its spread."
        ),
    ] = 3,
    coarse: Annotated[bool, typer.Option("--coarse", help="Run a third of the resolutions only.")] = False,
    out: Annotated[
        Path | None, options.folder_option("Folder of the result; an interrupted study continues.", "out/cost_SCENE")
    ] = None,
    elements: Annotated[
        str,
        typer.Option(
            "--elements",
            metavar="N,N,...",
            help="Run these meshes only, at the scene's step; adds hookload, torque and stick-slip.",
        ),
    ] = "",
    workers: options.WorkersOption = 0,
    json: options.JsonOption = False,
) -> None:
    """Measure error and processor time of a scene over formulations, elements, steps and tolerances.

    The error is that against a converged run. An interrupted study continues. Writes cost.json, cost.csv and cost.png.
    `drill-twin run --accuracy` chooses a resolution by a smaller study of its own.
    """
    from drill_twin.scene import load_scene
    from drill_twin.studies.accuracy import figures
    from drill_twin.studies.accuracy.convergence import (
        ELEMENTS,
        STEPS,
        choose_resolutions,
        measure,
        on_meshes,
    )
    from drill_twin.studies.accuracy.motion_run import require_marks

    changes = options.overrides(change, duration=duration)
    described = load_scene(scene, overrides=changes)
    require_marks(described)
    folder = out or Path("out") / f"cost_{folder_name(described.name)}"
    make_folder(folder / "runs")
    with shown_progress("building the string"):
        if elements:
            resolutions = on_meshes(described, options.meshes(elements, "125,250,500"))
        else:
            shares = (ELEMENTS[1::2], STEPS[1::2]) if coarse else (ELEMENTS, STEPS)
            resolutions = choose_resolutions(described, *shares)
    with shown_progress(
        "running", len(resolutions) + 1 + replicas, kept=f"the same command goes on from {folder / 'runs'}"
    ) as bar:
        curve = measure(
            scene, changes, resolutions, folder / "runs", replicas=replicas, workers=workers, progress=bar.step
        )
    data = asdict(curve)
    tables = (
        (figures.mesh_table,)
        if elements
        else (figures.cost_table, figures.tolerance_table, *([figures.mesh_table] if curve.whole else []))
    )
    emit(
        data, (table(curve) for table in tables), json=json, folder=folder, also=["runs"],
        files={"cost.json": data, "cost.csv": figures.runs_table(curve).csv(),
               "cost.png": lambda: figures.cost_figure(curve)},
    )  # fmt: skip


def effects(
    scene: options.SceneArgument,
    tolerance: Annotated[
        float,
        typer.Option(
            "--tolerance",
            metavar="SHARE",
            min=0.001,
            max=1.0,
            help="Smallest relevant change: relative for onset time and whirl frequency, absolute for mean orbit "
            "radius over clearance and for contact fraction.",
        ),
    ] = 0.05,
    replicas: Annotated[
        int,
        typer.Option(
            "--repeats",
            metavar="N",
            min=2,
            max=100,
            help="Runs of each set of effects, with small random differences.",
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
    from drill_twin.studies.accuracy.figures import ablation_figure, effects_table, effects_verdict

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
    emit(
        data, (part(ablation) for part in (effects_table, effects_verdict)), json=json, folder=folder, also=["runs"],
        files={"effects.json": data, "effects.png": lambda: ablation_figure(ablation)},
    )  # fmt: skip
