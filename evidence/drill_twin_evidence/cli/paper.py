# SPDX-License-Identifier: Apache-2.0
"""Commands `drill-twin paper` and `drill-twin calibrate`: reproduction of the paper, and calibration."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drill_twin.cli.options import JsonOption, ReplaceOption, WorkersOption

if TYPE_CHECKING:
    from drill_twin_evidence.paper.runs.reproduction import Reproduction

BENCH = "pa6_calibrated"
RESULT = ("paper.json", "paper.html", "paper.md")
CALIBRATION, TRADE_OFF = "calibration.json", "paper_trade_off.png"


def paper(
    scene: Annotated[str, typer.Option("--scene", metavar="SCENE", help="The bench, by name or file.")] = BENCH,
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="Folder of the result.")] = Path("out/paper"),
    workers: WorkersOption = 0,
    only_bench: Annotated[
        bool,
        typer.Option("--only-bench", help="Only the matrix of the bench: no variants, no full-size assembly."),
    ] = False,
    replace: ReplaceOption = False,
    json: JsonOption = False,
) -> None:
    """Run all cases of the paper and print each published number beside that of the twin: tables, figures, one page."""
    import time

    from drill_twin.cli.folder import check_new, write_file
    from drill_twin.cli.show import err, print_json
    from drill_twin.studies.json_io import json_text
    from drill_twin_evidence.paper.runs.reproduction import bench, reproduce

    described = bench(scene)
    for name in RESULT:
        check_new(out / name, replace=replace)
    began = time.monotonic()
    with _bar("the paper's runs") as show:
        done = reproduce(
            described, processes=workers, variants=not only_bench, full_size_too=not only_bench, progress=show
        )
    spent = time.monotonic() - began
    with err().status("drawing"):
        from drill_twin_evidence.paper.pages.figures import draw
        from drill_twin_evidence.paper.pages.markdown import build_markdown
        from drill_twin_evidence.paper.pages.page import build_page

        write_file(out / RESULT[0], json_text(done.to_dict()))
        figures = draw(done, out)
        write_file(out / RESULT[1], build_page(done, figures))
        write_file(out / RESULT[2], build_markdown(done))
    if json:
        print_json(done.to_dict())
    else:
        _print(done)
    err().print(f"{out}: {', '.join(RESULT)} and {len(figures)} figures; the runs took {spent:.0f} s", markup=False)


def calibrate(
    scene: Annotated[str, typer.Option("--scene", metavar="SCENE", help="Bench to start from.")] = BENCH,
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="Folder of the result.")] = Path("out/calibration"),
    seed: Annotated[int, typer.Option("--seed", min=0, help="Seed of the search.")] = 1,
    population: Annotated[int, typer.Option("--population", min=5, max=512, help="Members of a generation.")] = 16,
    generations: Annotated[
        int, typer.Option("--generations", min=0, help="Generations after the first; 0: only the scene as it is.")
    ] = 30,
    workers: WorkersOption = 1,
    replace: ReplaceOption = False,
    json: JsonOption = False,
) -> None:
    """Calibrate the parameters that the paper does not give (ramps, imperfections, damping, friction).

    Prints values, bounds and residuals. The fit starts from the scene and uses a part of the table; the rest
    validates it (`drill-twin paper`). A figure shows which numbers contradict each other. The search is differential
    evolution; the same seed gives the same result.
    """
    from drill_twin.cli.folder import check_new, write_file
    from drill_twin.cli.show import err, grid, print_json
    from drill_twin.cli.show import out as screen
    from drill_twin.studies.json_io import json_text
    from drill_twin_evidence.paper.calibration import text
    from drill_twin_evidence.paper.calibration.calibrate import calibrate as search
    from drill_twin_evidence.paper.runs.reproduction import bench

    described = bench(scene)
    for name in (CALIBRATION, TRADE_OFF):
        check_new(out / name, replace=replace)
    with _bar("calibration") as show:
        done = search(
            described, seed=seed, population=population, generations=generations, processes=workers,
            progress=lambda count, of, best: show(f"least loss {best:.3f}", count, of),
        )  # fmt: skip
    write_file(out / CALIBRATION, json_text(text.to_dict(done)))
    with err().status("drawing"):
        from drill_twin.report.figures.style import save, styled
        from drill_twin_evidence.paper.calibration.trade_off import draw_trade_off

        with styled():
            save(draw_trade_off(done.tried, done.best), out / TRADE_OFF)
    if json:
        print_json(text.to_dict(done))
    else:
        screen().print(text.title(done), markup=False)
        screen().print(grid(text.FOUND, text.found_rows(done), title="Values found", right=(1,)))
        screen().print(grid(text.RESIDUALS, text.residual_rows(done), title="Residuals", right=(1, 2, 3)))
    err().print(f"{out}: {CALIBRATION} and {TRADE_OFF}", markup=False)


def _print(done: Reproduction) -> None:
    from drill_twin.cli.show import grid, out
    from drill_twin_evidence.paper.pages import text

    screen = out()
    screen.print(text.lead(done), markup=False)
    screen.print(grid(text.NUMBERS, text.number_rows(done.rows), title="Numbers of the bench", right=(2, 3, 4)))
    screen.print(grid(text.TRENDS, text.trend_rows(done.trends), title="Trends"))
    screen.print(grid(text.RUNS, text.run_rows(done), title="All runs", right=(1, 2, 3, 4)))
    if done.variants:
        screen.print(
            grid(text.VARIANT, text.variant_rows(done.variants), title="Other readings of the bench", right=(2, 3, 4))
        )
    screen.print(grid(text.SCALES, text.scale_rows(done.scales), title="Rod and field"))
    if done.full_size:
        rows = text.full_size_rows(done.full_size)
        screen.print(grid(text.FULL_SIZE, rows, title="The full-size assembly, a stand-in", right=(2, 3)))
        disorder = text.disorder_rows(done.disorder)
        screen.print(grid(text.DISORDER, disorder, title="Disorder at 180 kN", right=(1, 2, 3)))


@contextmanager
def _bar(name: str) -> Iterator[Callable[[str, int, int], None]]:
    """Progress bar on stderr; called with a description, the number of runs done, and their total."""
    from drill_twin_evidence.cli.output import counting_bar

    progress, task = counting_bar(name)
    with progress:
        yield lambda what, count, of: progress.update(task, description=what, completed=count, total=of)
