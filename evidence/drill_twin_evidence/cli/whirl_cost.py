# SPDX-License-Identifier: Apache-2.0
"""Command `drill-twin whirl-cost`: error and processor time of growth rates and whirl states over elements."""

from __future__ import annotations

from typing import Annotated

import typer

from drill_twin.cli.options import JsonOption, SceneArgument, SetOption, meshes, overrides

ELEMENTS = "8,12,16,24,32"


def whirl_cost(
    scene: SceneArgument,
    elements: Annotated[str, typer.Option("--elements", metavar="N,N,...", help="Meshes.")] = ELEMENTS,
    change: SetOption = [],  # noqa: B006  typer makes a new list of it
    runs: Annotated[bool, typer.Option("--runs/--no-runs", help="Run each mesh in time too.")] = True,
    json: JsonOption = False,
) -> None:
    """Error and processor time of a steady whirl, its stability and the growth on the axis, over elements.

    Errors are relative to a mesh three times as fine as the finest one. A run in time of the scene on each mesh stands
    beside it.
    """
    from dataclasses import asdict

    from drill_twin.api.scenes import as_scene
    from drill_twin.cli.show import grid, print_json
    from drill_twin.cli.show import out as stdout
    from drill_twin_evidence.cli.output import counting_bar
    from drill_twin_evidence.whirl_compare.cost import whirl_cost as measure

    counts = meshes(elements, ELEMENTS)
    own = as_scene(scene, overrides(change))
    progress, task = counting_bar("meshes", len(counts))
    with progress:
        costs = list(
            measure(
                own, counts, runs=runs,
                progress=lambda count: progress.update(task, completed=count),
            )
        )  # fmt: skip
    if json:
        print_json([asdict(one) for one in costs])
        return
    rows = [
        (
            str(one.elements), f"{one.ratio_error:.1e}", f"{one.state_ms:.2g}", f"{one.growth_error:.1e}",
            f"{one.stability_ms:.2g}", f"{one.axis_error:.1e}", f"{one.map_ms:.2g}",
            "" if one.run_error is None else f"{one.run_error:.1e}", "" if one.run_ms is None else f"{one.run_ms:.0f}",
        )
        for one in costs
    ]  # fmt: skip
    columns = "elements", "whirl speed", "ms", "its growth", "ms", "on axis", "ms", "run", "ms"
    last = costs[-1]
    title = (
        f"{own.name}: errors and processor time of a state from a near one, of its growth, of a point of the map of "
        f"growth rates, and of a run. With {last.elements} elements: ratio {last.ratio:+.4f}, growth "
        f"{last.growth:+.4g} 1/s, on the axis {last.axis_growth:+.4g} 1/s"
    )
    stdout().print(grid(columns, rows, title=title, right=range(len(columns))))
