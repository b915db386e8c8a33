# SPDX-License-Identifier: Apache-2.0
"""Error of a map's onset boundary against dense grids of runs (python -m drill_twin_evidence.benchmarks.map_boundary).

The map of a scene is made, then patches on its boundary are filled with runs at half its step. Distances between the
two boundaries inside the patches are shares of the ranges. Broken off, it goes on: runs are kept in `--out`.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

import drill_twin as dt
from drill_twin.core.arrays import Array
from drill_twin.runs.ensemble import Threads
from drill_twin_studies.maps import OperatingMap, Plane, Span
from drill_twin_studies.maps.runs import Key, Runner, RunRecord
from drill_twin_studies.maps.search import open_journal


def main() -> None:
    """Make the map and the patches, and print the distances."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scene", nargs="?", default="pa6_bench")
    parser.add_argument("--wob", default="1..40 N")
    parser.add_argument("--rpm", default="60..390")
    parser.add_argument("--steps", type=int, default=128)
    parser.add_argument("--duration", type=float, default=30.0)
    parser.add_argument("--runs", type=int, default=1500)
    parser.add_argument("--patches", type=int, default=3)
    parser.add_argument("--cells", type=int, default=8, help="steps of the map along each side of a patch")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE")
    parser.add_argument("--out", type=Path, default=Path("out/map_boundary"))
    given = parser.parse_args()
    scene = dt.load_scene(given.scene, dict(pair.split("=", 1) for pair in given.set))
    began = time.process_time()
    found = dt.operating_map(
        scene, wob=given.wob, rpm=given.rpm, duration=given.duration, runs=given.runs, steps=given.steps,
        hysteresis=False, folder=given.out / "map", workers=given.workers,
    )  # fmt: skip
    spent = time.process_time() - began
    onset = sum("onset" in note for note in found.notes)
    distances = error(scene, found, given.patches, given.cells, given.out, given.workers)
    if not distances.size:
        sys.exit(f"{scene.name}: expected a boundary in these ranges, found none; choose others with --wob and --rpm")
    median, most, largest = np.quantile(distances, [0.5, 0.95, 1.0])
    said = {
        "scene": scene.name, "runs": len(found.records), "processor_seconds_of_new_runs": round(spent, 1),
        "stopped_by_the_number_of_runs": bool(onset), "points": int(distances.size),
        "median": round(median, 5), "quantile_95": round(most, 5), "largest": round(largest, 5),
    }  # fmt: skip
    given.out.mkdir(parents=True, exist_ok=True)
    (given.out / "error.json").write_text(json.dumps(said, indent=2) + "\n", "utf-8")
    print(f"{scene.name}: {len(found.records)} runs; {distances.size} points of {given.patches} patches compared")
    print(f"distance, % of the ranges: median {median:.2%}, 95 % of the points {most:.2%}, largest {largest:.2%}")


def error(scene: dt.Scene, found: OperatingMap, patches: int, cells: int, folder: Path, workers: int) -> Array:
    """Distances between the boundaries of a map and of dense patches, both ways, as shares of the ranges."""
    distances: list[float] = []
    for number, corner in enumerate(corners(found, patches, cells)):
        dense = patch(scene, found, corner, cells, folder / f"patch_{number}", workers)
        mine, true = (points_in(each, found.plane, dense.plane) for each in (found, dense))
        if mine.size and true.size:
            apart = np.hypot(*(mine[:, None] - true).transpose(2, 0, 1))
            distances += [*apart.min(0).tolist(), *apart.min(1).tolist()]
        elif mine.size or true.size:  # one has a boundary where the other has none
            distances.append(cells / found.plane.steps)
    return np.array(distances)


def corners(found: OperatingMap, patches: int, cells: int) -> list[tuple[int, int]]:
    """Lowest nodes of patches that are spread evenly along the boundary."""
    steps = found.plane.steps
    centres = sorted(
        {(round(a), round(b)) for a, b in lattice_points(found, found.plane)}, key=lambda node: (node[1], node[0])
    )
    if not centres:
        return []
    chosen = [centres[int(k)] for k in np.linspace(0, len(centres) - 1, patches + 2)[1:-1]]
    return [(min(max(i - cells // 2, 0), steps - cells), min(max(j - cells // 2, 0), steps - cells)) for i, j in chosen]


def patch(
    scene: dt.Scene, found: OperatingMap, corner: tuple[int, int], cells: int, folder: Path, workers: int
) -> OperatingMap:
    """Map of a patch, with a run at each node of a lattice of half the step."""
    low, high = found.plane.command(corner), found.plane.command((corner[0] + cells, corner[1] + cells))
    plane = Plane(Span(low[0], high[0]), Span(low[1], high[1]), 2 * cells)
    runner = Runner(scene, plane, found.duration, found.asked, (), Threads(workers))
    nodes = [Key(i, j) for i in range(plane.steps + 1) for j in range(plane.steps + 1)]
    return replace(found, plane=plane, records=kept_runs(runner, nodes, folder), growth=())


def kept_runs(runner: Runner, keys: Sequence[Key], folder: Path) -> dict[Key, RunRecord]:
    """Runs of a plane; those that a folder has are not made again."""
    plane = runner.plane
    setup = {
        "scene": runner.scene.to_yaml(), "duration": runner.duration, "time asked": runner.asked,
        "ranges": [list(plane.weight), list(plane.speed)],
    }  # fmt: skip
    journal = open_journal(folder, setup)
    known = dict(journal.results)
    for made in runner.run([key for key in dict.fromkeys(keys) if key not in known]):
        journal.add(made)
    return dict(journal.results)


def lattice_points(found: OperatingMap, plane: Plane) -> list[tuple[float, float]]:
    """Middles of the segments of a boundary, in steps of a plane."""
    return [plane.place(*np.mean(ends, axis=0)) for ends in found.lines(found.whirls)]


def points_in(found: OperatingMap, whole: Plane, patch: Plane) -> Array:
    """Points of a boundary inside a patch, as shares of the ranges, shape (points, 2)."""
    points = [
        whole.place(*where)
        for where in (np.mean(ends, axis=0) for ends in found.lines(found.whirls))
        if all(0.0 <= place <= patch.steps for place in patch.place(*where))
    ]
    return np.array(points).reshape(-1, 2) / whole.steps


if __name__ == "__main__":
    main()
