# SPDX-License-Identifier: Apache-2.0
"""Error of a map's boundary and of a statistic against runs.

    python -m drill_twin_evidence.benchmarks.many_runs_error MAP

The search for the onset is repeated on a `map.json` with fewer runs, its boundary compared with that of the map, both
ways. At a set-point on that boundary an ensemble draws uncertain numbers (Sobol sequence); the shares that
whirl in blocks of draws are compared with that of all. The time of a run is the mean of the ensemble.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np

import drill_twin as dt
from drill_twin.core.arrays import Array
from drill_twin.core.table import Table, markdown_row
from drill_twin.runs.ensemble import Threads
from drill_twin.scene import parse_scene
from drill_twin_evidence.benchmarks.growth_prior import Replayed
from drill_twin_evidence.benchmarks.map_boundary import lattice_points
from drill_twin_studies.api.maps import draws_of
from drill_twin_studies.maps import OperatingMap, read_map
from drill_twin_studies.maps.runs import SPEED, WEIGHT
from drill_twin_studies.maps.search import BoundarySearch

BUDGETS = (50, 100, 200, 400, 800)
VARY = {"effects.wall_friction.coefficient": (0.1, 0.3), "effects.bow.amplitude": (2e-5, 2e-4)}
DRAWS = 256


def main() -> None:
    """Print both tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("map", type=Path)
    found = read_map(parser.parse_args().map)
    whirls, seconds = draws_at(found, *on_boundary(found))
    print(Table(("runs", "processor time, s", "boundary: median", "95 %"), ()).markdown())
    for budget in BUDGETS:
        runs, distances = boundary_error(found, budget)
        median, most = np.quantile(distances, [0.5, 0.95])
        print(markdown_row([runs, f"{runs * seconds:.0f}", f"{median:.1%}", f"{most:.1%}"]))
        if runs < budget:
            break
    print(f"\n{DRAWS} draws: share that whirls {whirls.mean():.3f}\n")
    rows = []
    for count in (8, 16, 32, 64, 128):
        error = np.sqrt(np.mean((whirls.reshape(-1, count).mean(axis=1) - whirls.mean()) ** 2))
        rows.append((count, f"{count * seconds:.1f}", f"{error:.3f}"))
    print(Table(("draws", "processor time, s", "error of the share"), rows).markdown())


def boundary_error(found: OperatingMap, budget: int) -> tuple[int, Array]:
    """Runs of a search with a budget, and distances of its boundary from that of a map, both ways, in the ranges."""
    scene = parse_scene(found.scene)
    growth = np.array(found.growth) if len(found.growth) else None
    runner = Replayed(scene, found.plane, found.duration, found.asked, (), Threads(), found.regimes)
    search = BoundarySearch(runner, None, budget, lambda *_: None, growth)
    search.onset()
    fewer = replace(found, draws=(), records=search.records)
    mine, true = (np.array(lattice_points(each, found.plane)) / found.plane.steps for each in (fewer, found))
    apart = np.hypot(*(mine[:, None] - true).transpose(2, 0, 1))
    return len(search.records), np.concatenate([apart.min(0), apart.min(1)])


def on_boundary(found: OperatingMap) -> tuple[float, float]:
    """Set-point in the middle of the onset boundary: weight on bit [N], speed [rad/s]."""
    points = lattice_points(found, found.plane)
    weight, speed = found.plane.command(points[len(points) // 2])
    return weight, speed


def draws_at(found: OperatingMap, weight: float, speed: float) -> tuple[Array, float]:
    """Verdict on the whirl of each draw at a set-point, and processor time of a run [s]."""
    scene = parse_scene(found.scene)
    draws = draws_of(scene, DRAWS, VARY)
    vary = {key: [draw[key] for draw in draws] for key in draws[0]}
    overrides = {f"{WEIGHT}.value": weight, f"{SPEED}.value": speed}
    runs = dt.Ensemble(scene, vary, zipped=True, overrides=overrides).run(found.duration, outputs="findings")
    return np.isfinite(runs["onset_s"]).astype(float), runs.processor_seconds / DRAWS


if __name__ == "__main__":
    main()
