# SPDX-License-Identifier: Apache-2.0
"""Command `drill-twin paper-search`: search for a set of numbers that meets the paper, and what excludes what."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from drill_twin.cli.options import JsonOption

if TYPE_CHECKING:
    from drill_twin_evidence.paper.search.evaluate import Bench
    from drill_twin_evidence.paper.search.exclusion import Exclusion
    from drill_twin_evidence.paper.search.habits import Habit
    from drill_twin_evidence.paper.search.record import Record

TABLE, DATA, FIGURE = "exclusion.csv", "exclusion.json", "paper_exclusion.png"


def paper_search(
    record: Annotated[
        Path, typer.Option("--record", metavar="FILE", help="Record of the search (.jsonl); an old one goes on.")
    ] = Path("out/paper_search/record.jsonl"),
    sets: Annotated[
        int, typer.Option("--sets", metavar="N", min=0, help="Sets of numbers in all; 0: only what the record has.")
    ] = 200_000,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Seed of the search.")] = 1,
    scene: Annotated[str, typer.Option("--scene", metavar="SCENE", help="The bench.")] = "pa6_calibrated",
    friction: Annotated[
        Literal["falling", "joined"],
        typer.Option("--friction", help="joined: static and dynamic friction joined by STEPs, two numbers more."),
    ] = "falling",
    threads: Annotated[int, typer.Option("--threads", min=1, max=256, help="Sets run at a time.")] = 1,
    seconds: Annotated[float, typer.Option("--duration", min=2.0, max=120.0, help="Length of a run [s].")] = 30.0,
    out: Annotated[
        Path | None, typer.Option("--out", metavar="DIR", help="Folder of the result; left out: that of the record.")
    ] = None,
    show_habits: Annotated[
        bool, typer.Option("--habits", help="Run the bench with each habit of multibody codes too: friction, contact.")
    ] = False,
    json: JsonOption = False,
) -> None:
    """Search all that the paper leaves open for sets that meet its numbers, two at a time and as many as possible.

    Prints which published numbers exclude each other and which assumption, given up, makes them agree; writes the
    least misfit of each pair as table and figure, and the best sets as scenes, which `drill-twin paper --scene` judges
    with stretch, twist and the resolution of a run. The same seed gives the same sets; a search that was broken off
    goes on where it was.
    """
    from drill_twin.cli.folder import write_file
    from drill_twin.cli.show import err, print_json
    from drill_twin.studies.json_io import json_text
    from drill_twin_evidence.paper.runs.reproduction import bench
    from drill_twin_evidence.paper.search.evaluate import Bench
    from drill_twin_evidence.paper.search.exclusion import exclusion_of
    from drill_twin_evidence.paper.search.habits import habits
    from drill_twin_evidence.paper.search.record import Record
    from drill_twin_evidence.paper.search.space import scene_of_trial

    described = bench(scene)
    joined = friction == "joined"
    setup = {"seed": seed, "seconds": seconds, "scene": described.to_yaml(), "friction": friction if joined else None}
    kept = Record(record, setup)
    on = Bench(described, seconds, joined=joined)
    _search(on, kept, sets, seed, threads)
    found = exclusion_of(kept, on)
    folder = record.parent if out is None else out
    write_file(folder / DATA, json_text(found.to_dict()))
    write_file(folder / TABLE, found.to_csv())
    with err().status("drawing"):
        from drill_twin.report.figures.style import save, styled
        from drill_twin_evidence.paper.search.figure import draw_exclusion

        with styled():
            save(draw_exclusion(found), folder / FIGURE)
    scenes = [f"set_{number}.yaml" for number in range(1, len(found.finalists) + 1)]
    for name, one in zip(scenes, found.finalists, strict=True):
        own = scene_of_trial(described, one.trial).model_copy(update={"name": f"paper_{name.removesuffix('.yaml')}"})
        write_file(folder / name, own.to_yaml())
    habitual = habits(on) if show_habits else []
    if json:
        print_json(found.to_dict() | ({"habits": [one.to_dict() for one in habitual]} if habitual else {}))
    else:
        _print(found)
        if habitual:
            _print_habits(habitual)
    err().print(f"{folder}: {', '.join((TABLE, DATA, FIGURE, *scenes))}", markup=False, soft_wrap=True)


def _search(bench: Bench, record: Record, sets: int, seed: int, threads: int) -> None:
    from drill_twin_evidence.cli.output import counting_bar
    from drill_twin_evidence.paper.search.search import search

    progress, task = counting_bar("sets", sets)
    with progress:
        search(
            bench, record, sets=sets, seed=seed, threads=threads,
            progress=lambda done, of, _archive: progress.update(task, completed=done, total=max(done, of)),
        )  # fmt: skip


def _print_habits(found: list[Habit]) -> None:
    from drill_twin.cli.show import grid, out
    from drill_twin_evidence.paper.search import text

    title = "The bench as calibrated, with a habit of multibody codes"
    out().print(grid(text.HABITS, text.habit_rows(found), title=title, right=(1, 2, 3)))


def _print(found: Exclusion) -> None:
    from drill_twin.cli.show import grid, out
    from drill_twin_evidence.paper.search import text

    screen = out()
    for line in text.lead(found):
        screen.print(line, markup=False, soft_wrap=True)
    screen.print(grid(text.UNDER, text.under_rows(found), title="Pairs of numbers that no set meets", right=(1, 2)))
    screen.print(grid(text.ALONE, text.alone_rows(found), title="Each number", right=(1, 2, 3)))
    screen.print(grid(text.OPENED, text.opened_rows(found), title="Pairs excluded with all assumptions kept"))
    screen.print(grid(text.BEST, text.best_rows(found), title="Sets that meet most numbers", right=(1, 2)))
    screen.print(grid(text.VALUES, text.value_rows(found), title="Numbers of set 1", right=(1, 2, 3)))
    if rows := list(text.short_rows(found)):
        title = "Short plain spectra that give 0.28 and 0.29 Hz"
        screen.print(grid(text.SHORT, rows, title=title, right=(2, 3, 4)))
