# SPDX-License-Identifier: Apache-2.0
"""Share of a run that the effect `fatigue` takes: processor time with and without it, alternately, messages included.

Run it as `python -m drill_twin_evidence.benchmarks.fatigue_cost`.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from statistics import median

from drill_twin.runs.session_run import SessionRun
from drill_twin.scene import Scene, load_scene
from drill_twin.scene.set_points import Schedule

FRAMES, ROUNDS = 20, 25
ROD = "{sections: [{name: middle, distance_from_bit: 2.5 m}], smallest_range: 10 kPa}"


class Discard:
    """Recorder that keeps nothing."""

    def write(self, topic: str, stamp: int, raw: bytes) -> None:
        """Do nothing."""

    def write_all(self, messages: Sequence[tuple[str, int, bytes]]) -> None:
        """Do nothing."""


def seconds_of(run: SessionRun, schedule: Schedule) -> float:
    """Processor time of `FRAMES` frames [s]."""
    began = time.process_time()
    end = run.loop.frames + FRAMES
    while (left := end - run.loop.frames) > 0:
        run.follow(schedule.at, min(left, run.most_frames))
    return time.process_time() - began


def share(scene: Scene) -> float:
    """Median over the rounds of the time with the effect over that without, minus 1."""
    plain = scene.model_copy(update={"effects": scene.effects.model_copy(update={"fatigue": None})})
    schedule, runs = Schedule.from_scene(scene), [SessionRun(described, Discard()) for described in (scene, plain)]
    for run in runs:
        seconds_of(run, schedule)  # compiles
    rounds = ([seconds_of(run, schedule) for run in runs] for _ in range(ROUNDS))
    return median(counted / bare for counted, bare in rounds) - 1.0


if __name__ == "__main__":
    for name, overrides in (("bha_stress", {}), ("pa6_bench", {"effects.fatigue": ROD})):
        described = load_scene(name, overrides=overrides)
        count = len(described.effects.fatigue.sections)
        print(f"{name}, {count} section{'s' if count > 1 else ''}: {share(described):.1%} of a run")
