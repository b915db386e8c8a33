# SPDX-License-Identifier: Apache-2.0
"""Judgement of safe windows on random scenes (python -m drill_twin_evidence.benchmarks.safe_windows); resumable.

Scene n has the numbers of the seed n: rod, hole, friction, imbalance and ranges; every fourth has a bit whose torque
falls with its speed, on a string that can stick and slip. Its map is made; then runs of the time asked, at set-points
drawn in its windows, count what whirls or sticks, and an even grid of such runs over the ranges says how much of what
stays calm the windows cover. Seeds below 1000 are for tuning; the judgement begins at 1000.
"""

from __future__ import annotations

import argparse
import math
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

import drill_twin as dt
from drill_twin.api.scenes import as_scene
from drill_twin.core.arrays import Mask
from drill_twin.core.table import Table, markdown_row
from drill_twin.runs.ensemble import Threads
from drill_twin_evidence.benchmarks.advice_loop import COARSE
from drill_twin_evidence.benchmarks.map_boundary import kept_runs
from drill_twin_evidence.proportion import proportion_text
from drill_twin_studies.maps import OperatingMap, Regime
from drill_twin_studies.maps.proportions import proportion_interval
from drill_twin_studies.maps.runs import FINER, Key, Runner, RunRecord

DURATION, ASKED = 30.0, 300.0
"""Simulated time of a run of a map, and time for which a set-point of a window must stay calm [s]."""
EARLY = 60.0
"""Simulated time after which a point of the dense grid that whirls or sticks is not run on [s]."""
STEPS, RUNS = 32, 120
"""Steps and largest number of runs of a map."""
TORSION = 4
"""One scene of so many has a bit that can stick and slip."""
LARGEST = 0.05
"""Share of the set-points in windows that may whirl or stick."""


def main() -> None:
    """Judge the scenes that are missing, and print the counts."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--first", type=int, default=1000, help="seed of the first scene")
    parser.add_argument("--scenes", type=int, default=20)
    parser.add_argument("--points", type=int, default=14, help="runs in the windows of each scene")
    parser.add_argument("--grid", type=int, default=5, help="runs along each range of the dense grid")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--out", type=Path, default=Path("out/safe_windows"))
    given = parser.parse_args()
    began, judged = time.process_time(), list[dict[str, Any]]()
    print(Table(("scene", "runs", "windows", "whirl or stick", "calm of the grid", "of it in windows"), ()).markdown())
    for seed in range(given.first, given.first + given.scenes):
        judged.append(judge(seed, given.points, given.grid, given.out, given.workers))
        one = judged[-1]
        bad, calm = f"{one['bad']} of {one['points']}", f"{one['calm']} of {given.grid**2}"
        print(markdown_row([seed, one["runs"], one["windows"], bad, calm, one["covered"]]), flush=True)
    bad, points, calm, covered = (sum(one[name] for one in judged) for name in ("bad", "points", "calm", "covered"))
    most = proportion_interval(bad, points, 0.9)[1] if points else math.nan
    print(f"in windows, {ASKED:g} s: {proportion_text(bad, points)} whirl or stick; at most {most:.1%} (95 %)")
    print(f"coverage: {proportion_text(covered, calm)} of the calm points of the grids lie in windows")
    print(f"processor time of new runs: {time.process_time() - began:.0f} s")


def judge(seed: int, points: int, grid: int, out: Path, workers: int) -> dict[str, Any]:
    """Counts of a scene."""
    scene, wob, rpm = scene_of(seed)
    folder = out / f"scene_{seed}"
    found = dt.operating_map(
        scene, wob=wob, rpm=rpm, duration=DURATION, calm_for=ASKED, steps=STEPS, runs=RUNS, hysteresis=False,
        folder=folder / "map", workers=workers,
    )  # fmt: skip
    cells = found.window_cells
    inside = drawn_in(cells, points, seed)
    dense = [Key(i, j, 0, None, FINER) for i in spread(grid) for j in spread(grid)]
    plane = found.plane
    early = long_runs(scene, replace(found, asked=EARLY), dense, folder / "early", workers)
    later = [key for key in dense if not troubled(early[key])]  # a whirl that began does not make a calm point
    records = early | long_runs(scene, found, [*inside, *later], folder / "long", workers)
    bad = [key for key in inside if troubled(records[key])]
    calm = [key for key in dense if not troubled(records[key]) and records[key].regime is not Regime.BUCKLED]
    for key in bad:
        weight, speed = plane.command(key.place)
        print(f"  {seed}: {weight:.4g} N, {speed / math.tau:.4g} rev/s: {records[key].regime.value}, "
              f"onset {records[key].onset_s:.4g} s")  # fmt: skip
    return {
        "runs": len(found.records), "windows": len(found.windows), "bad": len(bad), "points": len(inside),
        "calm": len(calm), "covered": sum(bool(cells[key.node]) for key in calm),
    }  # fmt: skip


def troubled(record: RunRecord) -> bool:
    """A run whirled or stuck, or could not be followed."""
    return record.regime in {Regime.STICK_SLIP, Regime.FAILED} or record.whirls or math.isfinite(record.onset_s)


def drawn_in(cells: Mask, count: int, seed: int) -> list[Key]:
    """Checks at places that are drawn evenly in flagged cells."""
    random, places = np.random.default_rng((seed, 1)), np.argwhere(cells)
    if not len(places):
        return []
    chosen = places[random.integers(len(places), size=count)] * FINER + random.integers(FINER, size=(count, 2))
    return [Key(i, j, 0, None, FINER) for i, j in chosen.tolist()]


def spread(grid: int) -> list[int]:
    """Middles of an even grid along a range, in parts of a step."""
    return [int((k + 0.5) / grid * STEPS * FINER) for k in range(grid)]


def long_runs(
    scene: dt.Scene, found: OperatingMap, keys: list[Key], folder: Path, workers: int
) -> dict[Key, RunRecord]:
    """Runs of the time asked; those of a folder are not made again."""
    return kept_runs(Runner(scene, found.plane, found.duration, found.asked, (), Threads(workers)), keys, folder)


def scene_of(seed: int) -> tuple[dt.Scene, str, str]:
    """Scene of a seed and its ranges of weight on bit and speed."""
    draw, base = np.random.default_rng(seed).uniform, dt.load_scene("pa6_bench")
    length = draw(4.5, 6.5)
    numbers: dict[str, float | str] = COARSE | {
        "string.sections.0.length": length,
        "hole.radius": draw(0.05, 0.12),
        "effects.wall_friction.coefficient": draw(0.05, 0.35),
        "effects.bow.amplitude": 10.0 ** draw(-5.5, -3.7),
        "effects.eccentricity.offset": 10.0 ** draw(-5.5, -4.0),
        "effects.internal_damping.bending_time": draw(0.01, 0.05),
        "effects.drag.linear": 10.0 ** draw(-3.0, -1.7),
    }
    load = 3.3 * (5.0 / length) ** 2  # Euler's load, about
    most, fastest = draw(1.5, 5.0) * load, draw(2.0, 4.5)
    if seed % TORSION == 0:
        numbers |= {
            "effects.bit_mass.inertia": draw(0.005, 0.05),
            "effects.internal_damping.torsion_time": draw(0.01, 0.05),
            "effects.bit_torque_tanh.arm": draw(0.05, 0.2),
            "effects.bit_torque_tanh.excess": draw(0.2, 1.0),
            "effects.bit_torque_tanh.fall": draw(0.02, 0.2),
        }
        base = base.model_copy(update={"effects": base.effects.model_copy(update={"bit_friction": None})})
    return as_scene(base, numbers), f"{0.1 * load!r}..{most!r} N", f"0.4..{fastest!r}"


if __name__ == "__main__":
    main()
