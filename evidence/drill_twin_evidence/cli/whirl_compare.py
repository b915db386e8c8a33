# SPDX-License-Identifier: Apache-2.0
"""Command `drill-twin study whirl-compare`: steady whirl states against the simulation in time, on a grid."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drill_twin.cli.options import JsonOption, SceneArgument, SetOption, WorkersOption, overrides, time_option

if TYPE_CHECKING:
    from drill_twin.scene import Scene
    from drill_twin_evidence.whirl_compare.points import Point

GRID = "LO..HI:N"


def whirl_compare(
    scene: SceneArgument,
    wob: Annotated[str, typer.Option("--wob", metavar=GRID, help='Weights on bit, as "10..110:6 N".')],
    rpm: Annotated[str, typer.Option("--rpm", metavar=GRID, help='Speeds, as "60..390:6"; bare numbers: rev/min.')],
    duration: Annotated[float, time_option("--duration", "Simulated time of each run", 1.0)] = 60.0,
    change: SetOption = [],  # noqa: B006  typer makes a new list of it
    record: Annotated[
        Path | None,
        typer.Option("--record", metavar="FILE", help="Append each point to this file, and go on from it."),
    ] = None,
    workers: WorkersOption = 0,
    json: JsonOption = False,
) -> None:
    """Compare the steady whirls found for each load and speed with a run in time that begins on the axis.

    A run with two frequencies is compared with the motion that harmonic balance finds from it. On each stable state
    that the run is not on, another run begins. About 7 s a point with 16 elements in the lateral form.
    """
    from dataclasses import asdict

    from drill_twin.api.scenes import as_scene
    from drill_twin.cli.emit import emit
    from drill_twin.cli.show import shown_progress
    from drill_twin.core.table import Table
    from drill_twin_evidence.whirl_compare.comparison import compare
    from drill_twin_evidence.whirl_compare.points import sentences

    own = as_scene(scene, overrides(change))
    weights, turns = (_points(own, key, text) for key, text in (("wob", wob), ("rpm", rpm)))
    kept = f"the same command goes on from {record}" if record else "nothing was kept; with --record it would be"
    with shown_progress("points", len(weights) * len(turns), kept=kept) as bar:
        points = compare(
            own, weights, turns, duration=duration, record=record, workers=workers,
            progress=lambda count: bar.show("points", count),
        )  # fmt: skip
    columns = ("load N", "rev/s", "simulated", "ratio", "second", "stable states", "verdict", "tested")
    table = Table(columns, [_cells(point) for point in points], title=own.name, right=(0, 1, 3, 4))
    emit([asdict(point) for point in points], [table, " ".join(sentences(points))], json=json)


def _points(scene: Scene, key: str, text: str) -> list[float]:
    """Equally spaced values of a number of a scene in SI, from text such as "10..110:6 N"; five without a count."""
    from drill_twin.api.scenes import range_of
    from drill_twin.core.units.ranges import parse_range

    low, high = range_of(scene, key, text)
    return parse_range(key, text)._replace(low=low, high=high).points(5)


def _cells(point: Point) -> tuple[str, ...]:
    second = "" if point.second is None or point.motion == "irregular" else f"{point.second:+.3f}"
    stable = ", ".join(f"{ratio:+.3f}" for ratio in point.stable) or "none"
    command = f"{point.weight_on_bit:.4g}", f"{point.rotation / math.tau:.3g}"
    return (*command, point.motion, f"{point.ratio:+.4f}", second, stable, point.verdict, point.reason)
