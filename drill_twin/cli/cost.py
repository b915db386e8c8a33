# SPDX-License-Identifier: Apache-2.0
"""Commands `drill-twin cost` and `effects`: what resolution and effects of a scene cost, and what they change."""

from __future__ import annotations

from collections.abc import Iterator
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
    from drill_twin.studies.accuracy.convergence import Curve
    from drill_twin.studies.accuracy.errors import AblationQuantity, MotionErrors


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
    from drill_twin.studies.accuracy.convergence import (
        ELEMENTS,
        STEPS,
        choose_resolutions,
        measure,
        on_meshes,
        require_marks,
    )
    from drill_twin.studies.accuracy.figures import cost_figure

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
    tables = (_meshes,) if elements else (_table, _tolerances, *([_meshes] if curve.whole else []))
    emit(
        data, (table(curve) for table in tables), json=json, folder=folder, also=["runs"],
        files={"cost.json": data, "cost.csv": _all(curve).csv(), "cost.png": lambda: cost_figure(curve)},
    )  # fmt: skip


def _share(value: float | None) -> str:
    return "" if value is None else f"{value:.0e}".replace("e-0", "e-")


def _tolerances(curve: Curve) -> Table:
    tried = [one for one in curve.runs if one.resolution.tolerance is not None]
    rows = [
        (_share(one.resolution.tolerance), _share(one.errors.path), _share(one.errors.onset), f"{one.cost * 1e3:.3g}")
        for one in sorted(tried, key=lambda one: -(one.resolution.tolerance or 0.0))
    ]
    at = f" at {tried[0].resolution.elements} elements, {tried[0].resolution.step * 1e3:.3g} ms" if tried else ""
    return Table(("tolerance", "path", "onset", "ms/s"), rows, title=f"Tolerance{at}", right=range(4))


def _table(curve: Curve) -> Table:
    def errors(of: MotionErrors) -> Iterator[str]:
        return (_share(getattr(of, name)) for name in ("path", "onset", "frequency", "radius", "contact"))

    rows = [
        (one.resolution.form, str(one.resolution.elements), f"{one.resolution.step * 1e3:.2g}", *errors(one.errors),
         f"{one.cost * 1e3:.3g}", f"{one.realtime_factor:.0f}", f"{one.frame_p95 * 1e6:.0f}")
        for one in curve.front
    ]  # fmt: skip
    rows.append(("spread", "", "", *errors(curve.noise), "", "", ""))
    columns = ("form", "el.", "step", "path", "onset", "whirl", "orbit", "wall", "ms/s", "× rt", "p95")
    compiling = max(one.compile_seconds for one in curve.runs)
    title = (
        f"{curve.scene}: the cheapest resolution for each error, against {curve.reference.elements} elements and "
        f"{curve.reference.step * 1e3:.3g} ms in the {curve.reference.form} form.\n"
        "Step in ms. Errors: path and time of the onset; after it whirl frequency, mean radius of the orbit and share "
        "at the wall. "
        "Time: processor ms per simulated second, speed over real time (× rt), us that 95 % of the frames stay below; "
        f"compiling or loading took {compiling:.0f} s, once. Spread: of runs set apart by a push of 0.1 mm/s."
    )
    return Table(columns, rows, title=title, right=range(1, 11))


def _meshes(curve: Curve) -> Table:
    def row(elements: str, errors: MotionErrors, *price: str) -> tuple[str, ...]:
        found = (
            errors.path, errors.onset, errors.hookload, errors.torque, errors.stick_slip, errors.frequency,
        )  # fmt: skip
        return elements, *map(_share, found), *price

    whole = curve.whole
    step = (whole or curve.runs[0]).resolution.step
    rows = [
        row(f"{one.resolution.elements}{' whole' if one is whole else ''}", one.errors, f"{one.cost * 1e3:.3g}",
            f"{one.realtime_factor:.3g}")
        for one in sorted(curve.runs, key=lambda one: (one is whole, one.resolution.elements))
        if one.resolution.step == step and one.resolution.tolerance is None
    ]  # fmt: skip
    rows.append(row("spread", curve.noise, "", ""))
    title = (
        f"{curve.scene}: errors over elements at a step of {step * 1e3:.2g} ms, against "
        f"{curve.reference.elements} elements and {curve.reference.step * 1e3:.2g} ms"
        f"{' with the joint; whole: `lateral_from=0 m`, what the joint changes (path: marks above it)' * bool(whole)}"
        ".\n"
        "Path and time of the onset; means of hookload and torque over the second half; period of stick-slip; whirl "
        "frequency. Time: processor ms per simulated second, speed over real time (× rt). "
        "Spread: of runs set apart by a push of 0.1 mm/s."
    )
    columns = ("el.", "path", "onset", "hookload", "torque", "stick-slip", "whirl", "ms/s", "× rt")
    return Table(columns, rows, title=title, right=range(9))


def _all(curve: Curve) -> Table:
    """All runs with the numbers of each."""
    names = ("path", "onset", "frequency", "radius", "contact", "hookload", "torque", "stick_slip")
    columns = (
        "form", "elements", "step_s", "tolerance", *(f"error_{name}" for name in names), "cost_s_per_s",
        "realtime_factor", "frame_p95_s", "compile_s", "iterations_per_s", "on_front",
    )  # fmt: skip
    rows = (
        (
            one.resolution.form, one.resolution.elements, one.resolution.step, one.resolution.tolerance,
            *(getattr(one.errors, name) for name in names), one.cost,
            one.realtime_factor, one.frame_p95, one.compile_seconds, one.iterations, int(one.on_front),
        )
        for one in curve.runs
    )  # fmt: skip
    return Table(columns, rows)


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
    emit(
        data, (part(ablation) for part in (_effects_table, _verdict)), json=json, folder=folder, also=["runs"],
        files={"effects.json": data, "effects.png": lambda: ablation_figure(ablation)},
    )  # fmt: skip


def _effects_table(ablation: Ablation) -> Table:
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
