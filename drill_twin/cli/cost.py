# SPDX-License-Identifier: Apache-2.0
"""`drill-twin cost`: what accuracy costs in time."""

from __future__ import annotations

import csv
import io
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drill_twin.cli.options import JsonOption, SceneArgument, SetOption, overrides

if TYPE_CHECKING:
    from rich.table import Table

    from drill_twin.study.cost import Curve


def cost(
    scene: SceneArgument,
    duration: Annotated[
        str, typer.Option("--duration", metavar="TIME", help='Simulated time, as "30 s"; a bare number is in s.')
    ] = "",
    change: SetOption = [],  # noqa: B006  typer makes a new list of it
    replicas: Annotated[
        int, typer.Option("--replicas", min=0, max=50, help="Replicas of the converged run that tell its own spread.")
    ] = 3,
    coarse: Annotated[bool, typer.Option("--coarse", help="A short ladder: a third of the resolutions.")] = False,
    workers: Annotated[int, typer.Option("--workers", min=1, max=64, help="Processes at a time.")] = 2,
    out: Annotated[
        Path | None,
        typer.Option(
            "--out",
            metavar="DIR",
            help="Folder of the result; one that is there goes on.",
            show_default="out/cost_SCENE",
        ),
    ] = None,
    json: JsonOption = False,
) -> None:
    """Run a scene over forms, elements and steps: the error of each against a converged run, and its time.

    Broken off, it goes on where it was. Writes cost.json, cost.csv and cost.png.
    """
    from rich.progress import Progress

    from drill_twin.cli.folder import folder_name, write_file
    from drill_twin.cli.show import err, print_json
    from drill_twin.cli.show import out as stdout
    from drill_twin.report.summary import to_json
    from drill_twin.scene import load_scene
    from drill_twin.study.cost import ladder, measure
    from drill_twin.study.cost.curve import ELEMENTS, STEPS
    from drill_twin.study.cost.figure import draw

    changes = overrides(change, duration=duration)
    described = load_scene(scene, overrides=changes)
    folder = out or Path("out") / f"cost_{folder_name(described.name)}"
    with err().status("building the string"):
        rungs = ladder(described, *((ELEMENTS[1::2], STEPS[1::2]) if coarse else (ELEMENTS, STEPS)))
    with Progress(console=err(), transient=True) as progress:
        task = progress.add_task("running", total=len(rungs) + 1 + replicas)
        curve = measure(
            scene, changes, rungs, folder / "runs", replicas=replicas, workers=workers,
            progress=lambda line: progress.update(task, advance=1, description=line),
        )  # fmt: skip
    write_file(folder / "cost.json", to_json(curve.to_dict()))
    write_file(folder / "cost.csv", _csv(curve))
    draw(curve, folder / "cost.png")
    if json:
        print_json(curve.to_dict())
    else:
        stdout().print(_table(curve))
    err().print(f"{folder}: cost.json, cost.csv, cost.png, runs", markup=False, soft_wrap=True)


def _table(curve: Curve) -> Table:
    from drill_twin.cli.show import grid

    def share(value: float | None) -> str:
        return "" if value is None else f"{value:.1e}"

    rows = [
        (
            one.rung.form, str(one.rung.elements), f"{one.rung.step * 1e3:.3g} ms", share(one.errors.path),
            share(one.errors.onset), share(one.errors.frequency), share(one.errors.radius), share(one.errors.contact),
            f"{one.cost:.2e} s/s", f"{one.realtime_factor:.0f}", f"{one.frame_p95 * 1e3:.2g} ms",
        )
        for one in curve.front
    ]  # fmt: skip
    noise = curve.noise
    rows.append((
        "spread of replicas", "", "", share(noise.path), share(noise.onset), share(noise.frequency),
        share(noise.radius), share(noise.contact), "", "", "",
    ))  # fmt: skip
    columns = (
        "form",
        "elements",
        "step",
        "path",
        "onset",
        "frequency",
        "radius",
        "contact",
        "cost",
        "x real time",
        "frame p95",
    )
    title = (
        f"{curve.scene}: the cheapest resolution for each error, against {curve.reference.elements} elements and "
        f"{curve.reference.step * 1e3:.3g} ms in the {curve.reference.form} form"
    )
    return grid(columns, rows, title=title, right=range(1, 11))


def _csv(curve: Curve) -> str:
    text = io.StringIO()
    names = ("path", "onset", "frequency", "radius", "contact")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow((
        "form", "elements", "step_s", *(f"error_{name}" for name in names), "cost_s_per_s", "realtime_factor",
        "frame_p95_s", "compile_s", "iterations_per_s", "on_front",
    ))  # fmt: skip
    for one in curve.rungs:
        writer.writerow((
            one.rung.form, one.rung.elements, one.rung.step, *(getattr(one.errors, name) for name in names), one.cost,
            one.realtime_factor, one.frame_p95, one.compile_seconds, one.iterations, int(one.on_front),
        ))  # fmt: skip
    return text.getvalue()
