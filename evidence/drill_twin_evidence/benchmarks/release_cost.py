# SPDX-License-Identifier: Apache-2.0
"""Processor time of a run and of its analysis, of this tree and of an earlier one.

    git worktree add ../before REVISION
    python -m drill_twin_evidence.benchmarks.release_cost ../before

`pa6_bench` with 8 elements and steps of 10 ms, 30 s simulated. Each round measures both trees in turn, each in a
process of its own on one thread; the least of all rounds counts. Start-up and compiling are left out.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

HERE = Path(__file__).resolve().parents[3]
RUN, TWIN, PUSH = "run with analysis and bag [s]", "twin, 100 frames a second [s]", "sample of the analyzer [us]"
SUMMARY, COMMAND = "bag read, analysed and summarised [s]", "both, as `drill-twin run` does [s]"
MEMBER = "ensemble member with findings [s]"
MEMBERS, REPEATS, RATE = 4, 3, 100


def main() -> None:
    """Measure both trees and print the ratios."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("before", type=Path, help="folder of the earlier tree; - measures this process")
    parser.add_argument("--rounds", type=int, default=3)
    given = parser.parse_args()
    if str(given.before) == "-":
        print(json.dumps(measure()))
        return
    least: dict[Path, dict[str, float]] = {given.before.resolve(): {}, HERE: {}}
    for _ in range(given.rounds):
        for tree, found in least.items():
            for name, cost in _measured(tree).items():
                found[name] = min(found.get(name, cost), cost)
    before, now = least.values()
    before[COMMAND], now[COMMAND] = (found[RUN] + found[SUMMARY] for found in (before, now))
    print("| `pa6_bench`, 30 s | before | now | ratio |\n| --- | --- | --- | --- |")
    for name, cost in now.items():
        then = before.get(name, before[RUN])  # there was no ensemble: a member was a run
        print(f"| {name} | {then:.3g} | {cost:.3g} | {then / cost:.1f} |")


def _measured(tree: Path) -> dict[str, float]:
    environment = os.environ | {"PYTHONPATH": str(tree), "OMP_NUM_THREADS": "1"}
    own = tree / Path(__file__).resolve().relative_to(HERE)  # its rooms may have other names
    command = [sys.executable, str(own if own.exists() else __file__), "-"]
    printed = subprocess.run(command, env=environment, check=True, stdout=subprocess.PIPE).stdout
    costs: dict[str, float] = json.loads(printed.splitlines()[-1])
    return costs


def measure() -> dict[str, float]:
    """Costs of the tree that is imported, by name, with functions that both trees have."""
    import drill_twin as dt
    from drill_twin.dynamics.twin.twin import Twin
    from drill_twin.io.scene_geometry import mark_infos
    from drill_twin.report.recording import read_recording
    from drill_twin.report.summary import summarise
    from drill_twin.runs import Session
    from drill_twin.scene.set_points import Schedule
    from drill_twin.whirl import Analyzer

    resolution: dict[str, float | str] = {"numerics.elements": 8, "numerics.step": "10 ms", "duration": 30.0}
    scene = dt.load_scene("pa6_bench", resolution)
    session, schedule, infos = Session(scene), Schedule.from_scene(scene), mark_infos(scene)
    least = dict.fromkeys((RUN, SUMMARY, TWIN, PUSH), math.inf)
    for _ in range(REPEATS):
        with tempfile.TemporaryDirectory() as folder:
            began = time.process_time()
            session.run(Path(folder) / "bag_0")
            ran = time.process_time()
            summarise(read_recording(Path(folder) / "bag_0"))
            least[RUN], least[SUMMARY] = min(least[RUN], ran - began), min(least[SUMMARY], time.process_time() - ran)
        running = Twin(scene)
        commands = [schedule.at(frame / RATE) for frame in range(1, round(schedule.duration * RATE) + 1)]
        began = time.process_time()
        frames = [running.advance(command, 1.0 / RATE) for command in commands]
        least[TWIN] = min(least[TWIN], time.process_time() - began)
        analyzer = Analyzer(infos)
        samples = [
            (k * 10_000_000, f.marks.position, f.marks.spin, f.rig.top_drive_speed, f.marks.wall_force, f.rig.bit_speed)
            for k, f in enumerate(frames)
        ]
        began = time.process_time()
        for sample in samples:
            analyzer.push(*sample)
        least[PUSH] = min(least[PUSH], (time.process_time() - began) / len(samples) * 1e6)
    if hasattr(dt, "Ensemble"):
        ensemble = dt.Ensemble(scene, {"seed": range(MEMBERS)})
        least[MEMBER] = min(
            ensemble.run(outputs=("findings", "extremes", "contact"), workers=1).processor_seconds / MEMBERS
            for _ in range(REPEATS)
        )
    return least


if __name__ == "__main__":
    main()
