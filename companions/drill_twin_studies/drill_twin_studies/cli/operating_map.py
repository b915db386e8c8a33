# SPDX-License-Identifier: Apache-2.0
"""Command `drill-twin map`: operating map of a scene over weight on bit and speed."""

from pathlib import Path
from shlex import quote
from typing import Annotated

import typer

from drill_twin.cli import options
from drill_twin.cli.emit import emit, folder_name
from drill_twin.cli.show import shown_progress
from drill_twin.core.files.output import make_folder


def operating_map(
    scene: options.SceneArgument,
    wob: Annotated[str, typer.Option("--wob", metavar="LO..HI", help='Range of the weight on bit, as "1..300 N".')],
    rpm: Annotated[
        str,
        typer.Option("--rpm", metavar="LO..HI", help='Range of the speed, as "1..3 rev/s"; bare: rev/min.'),
    ],
    seeds: Annotated[
        int, typer.Option("--draws", metavar="N", min=1, max=1000, help="Number of draws of uncertain numbers.")
    ] = 1,
    vary: Annotated[
        list[str],
        typer.Option(
            "--vary",
            metavar="KEY=LO..HI",
            help='Draw this number from a range, as "wall_friction.coefficient=0.1..0.3"; repeatable.',
        ),
    ] = [],  # noqa: B006  typer makes a new list of it
    change: options.SetOption = [],  # noqa: B006
    duration: options.DurationOption = "",
    calm_for: Annotated[
        str,
        typer.Option(
            "--calm-for", metavar="TIME", help="Time for which calm windows must stay calm.",
            show_default="ten times a run's length",
        ),
    ] = "",
    runs: Annotated[
        int, typer.Option("--runs", metavar="N", min=1, max=1_000_000, help="Largest number of runs.")
    ] = 1500,
    steps: Annotated[
        int, typer.Option("--steps", metavar="N", help="A boundary is located within 1/N of each range; a power of 2.")
    ] = 128,
    no_hysteresis: Annotated[
        bool, typer.Option("--no-hysteresis", help="Leave out the boundary at which an existing whirl dies.")
    ] = False,
    workers: options.WorkersOption = 0,
    dask: Annotated[
        str, typer.Option("--dask", metavar="ADDRESS", help="Address of a Dask scheduler whose workers make the runs.")
    ] = "",
    out: Annotated[
        Path | None, options.folder_option("Folder of the result; an interrupted map is continued.", "out/map_SCENE")
    ] = None,
    replace: options.ReplaceOption = False,
    units: options.UnitsOption = "",
    json: options.JsonOption = False,
) -> None:  # fmt: skip
    """Map the regimes of motion over weight on bit and speed, and find windows in which the string stays calm.

    Runs crowd where the regime changes: the end of smooth motion first, then the onset of whirl, the other regimes,
    draws of seeds and uncertain numbers, and the boundary at which an existing whirl dies; at last runs of the whole
    time asked check the windows. Writes map.json, map.csv, map.html and map.png.
    """
    from drill_twin.core.units.system import typed_in_pounds
    from drill_twin.scene import load_scene
    from drill_twin_studies.api.maps import operating_map as make
    from drill_twin_studies.maps.drawing import build_page, map_figure, shown

    changes = options.overrides(change, duration=duration, units=units or ("field" if typed_in_pounds(wob) else ""))
    ranges = options.ranges_of("--vary", vary)
    described = load_scene(scene, overrides=changes)
    folder = out or Path("out") / f"map_{folder_name(described.name)}"
    make_folder(folder)
    runs_file = folder / "runs.jsonl"
    if replace and runs_file.exists():
        runs_file.replace(folder / "runs.jsonl.old")
    going_on = f"the same command goes on from {runs_file}"
    with shown_progress("calm", runs, unit="runs", kept=going_on, most=True) as bar:
        found = make(
            described, wob=wob, rpm=rpm, seeds=seeds, vary=ranges, runs=runs,
            hysteresis=not no_hysteresis, steps=steps, folder=folder, workers=workers, dask=dask,
            calm_for=calm_for or None,
            progress=lambda phase, done, expected: bar.show(phase, done, max(runs, expected)),
        )  # fmt: skip
    data = found.to_dict()
    settings = [
        f"--set {quote(f'{key}={value}')}" for key, value in changes.items() if key not in {"duration", "units"}
    ]
    emit(
        data, shown(found, described), json=json, folder=folder, also=["runs.jsonl"],
        files={
            "map.json": data, "map.csv": found.csv(),
            "map.html": build_page(found, " ".join([quote(scene), *settings])),
            "map.png": lambda: map_figure(found),
        },
    )  # fmt: skip
