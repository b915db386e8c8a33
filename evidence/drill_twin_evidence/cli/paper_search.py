# SPDX-License-Identifier: Apache-2.0
"""Command `drill-twin study paper-search`: search for a set of numbers that meets the paper, and what excludes what."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from drill_twin.cli.options import JsonOption, WorkersOption, time_option


def paper_search(
    record: Annotated[
        Path, typer.Option("--record", metavar="FILE", help="Record of the search (.jsonl); an old one goes on.")
    ] = Path("out/paper_search/record.jsonl"),
    sets: Annotated[
        int, typer.Option("--sets", metavar="N", min=0, help="Sets of numbers in all; 0: only what the record has.")
    ] = 4000,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Seed of the search.")] = 1,
    scene: Annotated[str, typer.Option("--scene", metavar="SCENE", help="The bench.")] = "pa6_calibrated",
    friction: Annotated[
        Literal["falling", "joined"],
        typer.Option(
            "--friction",
            help="Law of friction; joined: static and dynamic friction joined by STEPs, with two numbers more.",
        ),
    ] = "falling",
    workers: WorkersOption = 0,
    seconds: Annotated[float, time_option("--duration", "Simulated time of a run", 2.0, 120.0)] = 30.0,
    out: Annotated[
        Path | None, typer.Option("--out", metavar="DIR", help="Folder of the result; left out: that of the record.")
    ] = None,
    show_habits: Annotated[
        bool,
        typer.Option("--habits", help="Run the bench with the friction and the contact of usual multibody codes too."),
    ] = False,
    json: JsonOption = False,
) -> None:
    """Search all that the paper leaves open for sets that meet its numbers, two at a time and as many as possible.

    Prints which published numbers exclude each other and which assumption, given up, makes them agree; writes the
    least misfit of each pair as table and figure, and the best sets as scenes, which `drill-twin study paper --scene`
    judges with stretch, twist and the resolution of a run. The same seed gives the same sets; a search that was broken
    off goes on where it was.
    """
    from dataclasses import asdict

    from drill_twin.cli.emit import emit
    from drill_twin.cli.show import shown_progress
    from drill_twin.report.figures.style import styled
    from drill_twin.scene.load import override
    from drill_twin_evidence.paper.runs.reproduction import bench
    from drill_twin_evidence.paper.search import search as searching
    from drill_twin_evidence.paper.search.bench import Bench
    from drill_twin_evidence.paper.search.exclusion import exclusion_of, lead, tables
    from drill_twin_evidence.paper.search.figure import draw_exclusion
    from drill_twin_evidence.paper.search.habits import habit_table, habits

    on = Bench(bench(scene), seconds, joined=friction == "joined", workers=workers)
    setup = {"seed": seed, "seconds": seconds, "scene": on.scene.to_yaml(), "friction": friction}
    kept = searching.open_record(record, setup)
    with shown_progress("sets", sets, unit="sets", kept=f"the same command goes on from {record}") as bar:
        searching.search(on, kept, sets=sets, seed=seed, progress=lambda done: bar.show("sets", done))
    found = exclusion_of(searching.evaluated(kept), on)
    habitual = habits(on) if show_habits else {}
    named = {f"set_{k}": override(on.scene, one.parameters.keys()) for k, one in enumerate(found.finalists, 1)}
    files = {"exclusion.csv": found.to_csv(), "exclusion.json": found.to_dict()}
    files |= {f"{k}.yaml": own.model_copy(update={"name": f"paper_{k}"}).to_yaml() for k, own in named.items()}
    plain: dict[str, Any] = {name: [asdict(run) for run in runs] for name, runs in habitual.items()}
    with styled():
        emit(
            found.to_dict() | ({"habits": plain} if plain else {}),
            (lead(found), *tables(found), *([habit_table(habitual)] if habitual else [])),
            json=json,
            folder=record.parent if out is None else out,
            files=files | {"paper_exclusion.png": draw_exclusion(found)},
        )
