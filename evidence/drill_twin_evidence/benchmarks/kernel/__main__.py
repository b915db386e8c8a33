# SPDX-License-Identifier: Apache-2.0
"""`python -m drill_twin_evidence.benchmarks.kernel effects | growth | machine | memory`."""

from __future__ import annotations

from typing import Annotated

import typer

from drill_twin.cli.emit import say
from drill_twin.cli.show import shown_progress
from drill_twin.core.table import Table
from drill_twin.dynamics.discretisation.kernel_arguments import LATERAL, SPATIAL
from drill_twin_evidence.benchmarks.kernel import machine as limits
from drill_twin_evidence.benchmarks.kernel.examples import EXAMPLES, forms_of, full_scene, scene_with
from drill_twin_evidence.benchmarks.kernel.measure import Cost, least_cost, memory_over

app = typer.Typer(help=__doc__, no_args_is_help=True, add_completion=False)
BARE = "bare rod"
GROWTH = (10, 20, 50, 100, 200, 500, 1000, 2000)


@app.command()
def effects(
    elements: Annotated[int, typer.Option("--elements", min=4)] = 200,
    only: Annotated[str, typer.Option("--only", help="Rows that hold this word.")] = "",
) -> None:
    """Print the cost of each effect on top of the bare rod, in both forms; each set of effects compiles once (20 s)."""
    names = [BARE, *(name for name in EXAMPLES if only in name)]
    found: dict[tuple[str, str], Cost] = {}
    with shown_progress("measuring") as bar:
        for form in (SPATIAL, LATERAL):
            for name in (name for name in names if form in forms_of(name)):
                bar.show(f"{form}: {name}")
                found[form, name] = least_cost(scene_with(name, form, elements))
    rows = []
    for name in names:
        cells = [name]
        for form in forms_of(name):
            cost, bare = found[form, name], found[form, BARE]
            more = "" if name == BARE else f"{cost.per_iteration / bare.per_iteration - 1.0:+.0%}"
            cells += [f"{cost.per_step:.0f}", f"{cost.per_iteration:.0f}", more]
        rows.append([*cells, *("" for _ in range(7 - len(cells)))])
    heads = ("effect", *(f"{form}: ns per element-{unit}" if unit else "over the bare rod"
                         for form in (SPATIAL, LATERAL) for unit in ("step", "iteration", "")))  # fmt: skip
    say(Table(heads, rows, title=f"What each effect costs, {elements} elements, step 1 ms", right=range(1, 7)))


@app.command()
def growth() -> None:
    """Cost against the number of elements, 10 to 2,000: it grows linearly."""
    rows = []
    for elements in GROWTH:
        cells = [f"{elements:,}"]
        for form in (SPATIAL, LATERAL):
            cost = least_cost(full_scene(elements, form), settle=0.2, repeats=3)
            cells += [f"{cost.per_step * elements / 1e3:.1f} us", f"{cost.per_iteration:.0f}"]
        rows.append(cells)
    heads = ("elements", *(f"{form}: {what}" for form in (SPATIAL, LATERAL)
                           for what in ("time of a step", "ns per element-iteration")))  # fmt: skip
    say(Table(heads, rows, title="The peers' scene, step 1 ms", right=range(5)))


@app.command()
def machine() -> None:
    """Print the limit of one core, and the shares of the block solver and of a whole iteration."""
    peak, flops, spent = limits.peak_gigaflops(), limits.solve_flops(), limits.solve_nanoseconds()
    whole = least_cost(scene_with(BARE, SPATIAL, 200)).per_iteration
    say(Table((), [
        ("multiply-adds in registers", f"{peak:.1f} GFLOP/s"),
        ("block solve, 7 x 7", f"{spent:.0f} ns per element, {flops} operations: {flops / spent:.1f} GFLOP/s"),
        ("at the machine's limit it would take", f"{flops / peak:.0f} ns"),
        ("whole iteration, bare rod in space", f"{whole:.0f} ns per element; the solve is {spent / whole:.0%} of it"),
    ]))  # fmt: skip


@app.command()
def memory(
    steps: Annotated[float, typer.Option("--steps", help="Steps to take, such as 1e8.")] = 1e6,
    elements: Annotated[int, typer.Option("--elements", min=4)] = 50,
    form: Annotated[str, typer.Option("--form", help="spatial or lateral")] = LATERAL,
) -> None:
    """Memory in use over many steps: it stays flat."""
    looks = []
    for taken, time, mebibytes in memory_over(full_scene(elements, form, rate=1.0), int(steps)):
        looks.append(mebibytes)
        say(f"{taken:>12,} steps  {time:>10,.0f} s simulated  {mebibytes:8.2f} MiB")
    say(f"growth from the first look to the last: {looks[-1] - looks[0]:+.2f} MiB")


if __name__ == "__main__":
    app()
