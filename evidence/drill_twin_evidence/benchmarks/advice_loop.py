# SPDX-License-Identifier: Apache-2.0
"""Random scenes that whirl, and a driver that takes each advice; resumable.

    python -m drill_twin_evidence.benchmarks.advice_loop

Scene n has the numbers of the seed n on the paper's rod, coarsely resolved. Its map has at most 100 runs. The string
starts at a set-point of its own; if it whirls after the time of a run of the map, the advice is followed until the
whirl has ended. With `--lowest 0.7` most ranges have nothing calm, and the driver must be told so. Each result is one
line of a file; a broken campaign goes on behind the last whole line.
"""

from __future__ import annotations

import argparse
import math
from collections import Counter
from pathlib import Path
from typing import NotRequired

import numpy as np
from typing_extensions import TypedDict

import drill_twin as dt
from drill_twin.core.files.json_files import JsonLines
from drill_twin.io.messages.diagnostics import Level
from drill_twin.scene.set_points import Command
from drill_twin.whirl import MotionCode
from drill_twin_studies.maps.advice import Adviser, Tracker

COARSE: dict[str, float | str] = {
    "numerics.elements": 8, "numerics.step": "10 ms", "numerics.frame_rate": "50 Hz",
    "rig.rotation.duration": 1.0, "rig.weight_on_bit.duration": 1.0,
}  # fmt: skip
_WHIRLS = frozenset(code.state.value for code in MotionCode if code.whirls)
DURATION = 10.0
"""Simulated time of a run of the map [s]."""
GIVEN_UP, CHANGE, CALM = 120.0, 2.5, 2.0
"""Simulated time after which a driver gives up, time of a change of set-points, time without whirl at its end [s]."""
LEFT, STAYED, NO_WHIRL = "left whirl", "whirls on", "no whirl at first"
TOLD, NOT_TOLD = "told that it cannot", "not told"


class Found(TypedDict):
    """Result of a scene."""

    scene: int
    numbers: dict[str, float]
    end: str
    runs: NotRequired[int]
    advice: NotRequired[list[str]]


def main() -> None:
    """Run the scenes that are missing, and print the counts."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scenes", type=int, default=50, help="scenes that whirl at first")
    parser.add_argument("--lowest", type=float, default=0.025, help="lower ends of the ranges, over the set-points")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--out", type=Path, default=Path("out/advice_loop"))
    given = parser.parse_args()
    setup = {"lowest": given.lowest, "duration": DURATION}
    file = JsonLines(given.out / "results.jsonl", Found, "advice loop", setup, remedy="take another --out")
    known = {result["scene"]: result for result in file.results}
    results: list[Found] = []
    while sum(result["end"] != NO_WHIRL for result in results) < given.scenes:
        number = len(results)
        if number not in known:
            known[number] = result_of(number, given.lowest, given.out, given.workers)
            file.add(known[number])
        results.append(known[number])
    counts = Counter(result["end"] for result in results)
    print("\n".join(f"{name}: {counts[name]}" for name in (LEFT, STAYED, TOLD, NOT_TOLD, NO_WHIRL)))
    if whole := counts[LEFT] + counts[STAYED]:
        print(f"with a calm set-point in the map: {counts[LEFT] / whole:.0%} leave the whirl, ", end="")
        said = [result.get("advice", ()) for result in results if result["end"] == LEFT]
        stops = sum("stop the rotation" in "".join(advice) for advice in said)
        print(f"{sum(len(advice) == 1 for advice in said)} by one advice, {stops} after a stop of the rotation")


def result_of(number: int, lowest: float, out: Path, workers: int) -> Found:
    """Numbers and end of a scene; the runs of its map are kept."""
    numbers = drawn(number)
    scene = dt.load_scene("pa6_bench", {**COARSE, **numbers})
    weight, speed = scene.rig.weight_on_bit.value, scene.rig.rotation.value
    simulation = dt.Simulation(scene)
    simulation.run(duration=DURATION)
    if simulation.state is None or simulation.state.motion not in _WHIRLS:
        return {"scene": number, "numbers": numbers, "end": NO_WHIRL}
    found = dt.operating_map(
        scene, wob=f"{lowest * weight!r}..{1.1 * weight!r} N", rpm=f"{lowest * speed!r}..{1.1 * speed!r} rad/s",
        duration=DURATION, runs=100, steps=8, workers=workers, folder=out / f"map_{number}_from_{lowest:g}",
    )  # fmt: skip
    possible = bool(found.calm.any())
    end, advice = follow(simulation, Adviser(found))
    if not possible:
        end = TOLD if "no calm set-point" in "".join(advice[-1:]) else NOT_TOLD
    return {"scene": number, "numbers": numbers, "runs": len(found.records), "end": end, "advice": advice}


def drawn(number: int) -> dict[str, float]:
    """Numbers of a scene."""
    draw = np.random.default_rng(number).uniform
    return {
        "hole.radius": round(draw(0.07, 0.11), 4),
        "effects.wall_friction.coefficient": round(draw(0.1, 0.35), 3),
        "effects.bow.amplitude": round(draw(2e-5, 2e-4), 6),
        "effects.eccentricity.offset": round(draw(1e-5, 1e-4), 6),
        "effects.internal_damping.bending_time": round(draw(0.01, 0.05), 4),
        "effects.drag.linear": round(draw(1e-3, 8e-3), 5),
        "rig.weight_on_bit.value": round(draw(15.0, 60.0), 1),
        "rig.rotation.value": round(math.tau * draw(1.0, 4.0), 2),
    }


def follow(simulation: dt.Simulation, adviser: Adviser) -> tuple[str, list[str]]:
    """End of a run that takes each advice, and the advice."""
    rig = simulation.scene.rig
    tracker, said = Tracker(), list[str]()
    begin = end = Command(rig.weight_on_bit.value, rig.rotation.value)
    changed, calm_since, first = -math.inf, math.inf, simulation.time
    while simulation.time < first + GIVEN_UP:
        share = min((simulation.time - changed) / CHANGE, 1.0)
        weight = begin.weight_on_bit + share * (end.weight_on_bit - begin.weight_on_bit)
        state = simulation.follow(Command(weight, begin.rotation + share * (end.rotation - begin.rotation)))
        tracker.take(state.time, state.weight_on_bit, state.rpm * math.tau / 60.0)
        whirls = state.motion in _WHIRLS
        advice = tracker.advise(adviser, whirls=whirls)
        if advice is None:
            continue
        if advice.level is Level.OK and not whirls:
            calm_since = min(calm_since, state.time)
            if state.time - calm_since >= CALM:
                return LEFT, said
        else:
            calm_since = math.inf
        if (
            share >= 1.0
            and advice.target is not None
            and (wanted := Command(advice.target.weight, advice.target.speed)) != end
        ):
            begin, end, changed = end, wanted, state.time
            said.append(advice.text)
        elif advice.target is None and advice.level is Level.ERROR:
            return STAYED, [*said, advice.text]
    return STAYED, said


if __name__ == "__main__":
    main()
