# SPDX-License-Identifier: Apache-2.0
"""Command `drill-twin whirl-compare`: steady whirl states against the simulation in time, on a grid."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drill_twin.cli.options import JsonOption, SceneArgument, SetOption, WorkersOption, overrides

if TYPE_CHECKING:
    from drill_twin.studies.rotordynamics.comparison import Point

GRID = "LOW:HIGH:N"


def whirl_compare(
    scene: SceneArgument,
    loads: Annotated[str, typer.Option("--loads", metavar=GRID, help="Weights on bit [N].")],
    speeds: Annotated[str, typer.Option("--speeds", metavar=GRID, help="Speeds in rev/s.")],
    duration: Annotated[float, typer.Option("--duration", min=1.0, help="Simulated time of each run in s.")] = 60.0,
    change: SetOption = [],  # noqa: B006  typer makes a new list of it
    record: Annotated[
        Path | None,
        typer.Option("--record", metavar="FILE", help="Append each point to this file, and go on from it."),
    ] = None,
    workers: WorkersOption = 2,
    json: JsonOption = False,
) -> None:
    """Compare the steady whirls found for each load and speed with a run in time that begins on the axis.

    Where a run settles beside a stable state, a second one begins on that state. About 6 s a point with 16 elements in
    the lateral form.
    """
    from dataclasses import asdict

    import numpy as np

    from drill_twin.api.scenes import as_scene
    from drill_twin.cli.show import grid, print_json
    from drill_twin.cli.show import out as stdout
    from drill_twin.cli.studies.output import counting_bar
    from drill_twin.studies.rotordynamics.comparison import compare

    weights, turns = _values("--loads", loads), [math.tau * value for value in _values("--speeds", speeds)]
    own = as_scene(scene, overrides(change))
    progress, task = counting_bar("points", len(weights) * len(turns))
    with progress:
        points = compare(
            own, weights, turns, duration=duration, record=record, workers=workers,
            progress=lambda count: progress.update(task, completed=count),
        )  # fmt: skip
    if json:
        print_json([asdict(point) for point in points])
        return
    columns = ("load N", "rev/s", "simulated", "ratio", "second", "stable states", "verdict", "reason")
    stdout().print(grid(columns, [_cells(point) for point in points], title=own.name, right=(0, 1, 3, 4)))
    agreed = sum(point.agrees for point in points)
    whirls = [point for point in points if point.motion == "steady whirl" and point.verdict == "a stable state"]
    apart = max((min(abs(point.ratio / ratio - 1.0) for ratio in point.stable) for point in whirls), default=np.nan)
    explained = sum(bool(point.reason) for point in points if not point.agrees)
    lines = [
        f"{agreed} of {len(points)} points agree; of the others {explained} have a reason that was tested.",
        f"{len(whirls)} runs end in a steady whirl that is a stable state"
        + (f"; whirl speeds differ by {apart:.2%} at most." if whirls else "."),
    ]
    changes = [(point.change, point.modulation) for point in whirls if point.change and point.modulation]
    if changes:
        lines.append(
            "Their shape changes by "
            + ", ".join(f"{simulated:.1e} ({first:.1e})" for simulated, first in changes)
            + " of the clearance; in brackets the modulation by bow and eccentricity, to first order."
        )
    stdout().print(" ".join(lines), markup=False, soft_wrap=True)


def _cells(point: Point) -> tuple[str, ...]:
    second = "" if point.second is None or point.motion == "irregular" else f"{point.second:+.3f}"
    stable = ", ".join(f"{ratio:+.3f}" for ratio in point.stable) or "none"
    command = f"{point.weight_on_bit:.4g}", f"{point.rotation / math.tau:.3g}"
    return (*command, point.motion, f"{point.ratio:+.4f}", second, stable, point.verdict, point.reason)


def _values(option: str, text: str) -> list[float]:
    """Equally spaced values from LOW:HIGH:N."""
    import numpy as np

    from drill_twin.errors import SceneError

    try:
        low, high, count = text.split(":")
        values: list[float] = np.linspace(float(low), float(high), int(count)).tolist()
    except ValueError:
        values = []
    if not values or not all(map(math.isfinite, values)) or values[0] > values[-1]:
        raise SceneError(f'{option}: expected {GRID} such as "10:110:6" with LOW not above HIGH, found "{text}"')
    return values
