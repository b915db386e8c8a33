# SPDX-License-Identifier: Apache-2.0
"""A day of simulated rotation (`hard/steady_hour`), hour by hour; resumable.

    python evidence/test/stress/day.py

Each hour ends with a line of results and a checkpoint. A run that is broken off goes on from the last checkpoint, bit
for bit, and ends with the same table. The exit code is 1 if the day is not in order (`stress.run.verdict_on`).
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from drill_twin.core.table import Table
from drill_twin.dynamics.twin.checkpoint import Checkpoint
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.runs.ensemble.parts import frames_of
from drill_twin.scene import Scene, load_scene
from drill_twin.scene.set_points import Schedule
from drill_twin_evidence.stress.bound import allowed_depth
from drill_twin_evidence.stress.case import HardCase
from drill_twin_evidence.stress.run import RunStatistics, verdict_on

PERIOD = 0.1  # of a frame [s]
HOUR = 3600.0  # [s]


class Hour(NamedTuple):
    """Results of an hour."""

    number: int  # from 1
    steps: int
    iterations: int
    halvings: int
    interventions: int
    depth: float  # largest penetration of the wall [m]
    speed: float  # largest lateral speed [m/s]
    radius: float  # of the bit off the axis at the end [m]
    turns: float  # of the bit since the start [rev]
    verdict: str


def scene_of(hours: int, seconds: float) -> Scene:
    """The scene."""
    return load_scene("hard/steady_hour", overrides={"duration": str(hours * seconds)})


def hour_of(number: int, twin: Twin, seconds: float) -> Hour:
    """Run an hour."""
    found, frames = RunStatistics(), round(seconds / PERIOD)
    schedule = Schedule.from_scene(twin.scene)
    commands = schedule.over(PERIOD * (k + 1) for k in range((number - 1) * frames, number * frames))
    for part in frames_of(twin, commands, PERIOD):
        found.add(part)
    case = HardCase("hard/steady_hour", "spatial", "", seconds)
    allowed = allowed_depth(twin, found.speed) + 0.5 * twin.step_size * found.speed
    (x, y, _), turns = part.positions[-1, 0], part.spin[-1, 0] / 6.283185307179586
    return Hour(
        number, found.steps, found.iterations, found.cut_steps, found.interventions, float(found.depth), found.speed,
        float((x * x + y * y) ** 0.5), float(turns), verdict_on(case, found, "", allowed),
    )  # fmt: skip


def run(folder: Path, hours: int = 24, seconds: float = HOUR) -> list[Hour]:
    """Run what the folder does not hold yet; returns all hours.

    Args:
        folder: Of `day.jsonl` and `day.npz`.
        hours: Number of hours.
        seconds: Length of one [s].
    """
    lines, kept = folder / "day.jsonl", folder / "day.npz"
    folder.mkdir(parents=True, exist_ok=True)
    scene = scene_of(hours, seconds)
    twin, schedule, done = Twin(scene), Schedule.from_scene(scene), []
    if kept.exists():
        Checkpoint.load(kept).restore(twin)
        count = round(twin.time / seconds)
        done = [Hour(*json.loads(line)) for line in lines.read_text("utf-8").splitlines()[:count]]
    lines.write_text("".join(json.dumps(list(hour)) + "\n" for hour in done), "utf-8")
    for number in range(len(done) + 1, hours + 1):
        done.append(hour_of(number, twin, seconds))
        with lines.open("a", encoding="utf-8") as file:
            file.write(json.dumps(list(done[-1])) + "\n")
        Checkpoint.of(twin, schedule.at(number * seconds)).save(kept)  # after the line: a kill between repeats the hour
    return done


def table(done: Sequence[Hour]) -> str:
    """The hours as Markdown."""
    columns = (
        "hour",
        "steps",
        "iterations",
        "halvings",
        "repeated",
        "depth [mm]",
        "speed [m/s]",
        "turns of the bit",
        "",
    )
    rows = (
        (
            hour.number, hour.steps, hour.iterations, hour.halvings, hour.interventions, f"{1e3 * hour.depth:.3g}",
            f"{hour.speed:.3g}", f"{hour.turns:.1f}", hour.verdict,
        )
        for hour in done
    )  # fmt: skip
    return Table(columns, rows).markdown()


def main(words: Sequence[str] | None = None) -> int:
    """Run the day and print its table."""
    parser = argparse.ArgumentParser(description=str(__doc__).partition("\n")[0])
    parser.add_argument("--folder", type=Path, default=Path("out/day"), help="folder of results and checkpoint")
    parser.add_argument("--hours", type=int, default=24, help="simulated hours")
    given = parser.parse_args(words)
    done = run(given.folder, given.hours)
    print(table(done))
    return 0 if all(hour.verdict == "ok" for hour in done) else 1


if __name__ == "__main__":
    sys.exit(main())
