# SPDX-License-Identifier: Apache-2.0
"""Expected and used time of runs with an accuracy, cost of measuring, and cost of the choice over the cheapest.

    python -m drill_twin_evidence.benchmarks.accuracy_cost           # expected against used; a process for each run
    python -m drill_twin_evidence.benchmarks.accuracy_cost --choice  # the choice against the cheapest that keeps it
    python -m drill_twin_evidence.benchmarks.accuracy_cost --ship    # measures the curves of config/accuracy anew

Each line is written to a file, `--out`; an interrupted benchmark continues.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from drill_twin.core.files.json_files import JsonLines

if TYPE_CHECKING:
    from drill_twin.studies.accuracy.motion_run import Motion

SHIPPED = {"pa6_bench": {}, "bha_full_size": {"duration": "20 s"}}
"""Scenes with a shipped curve, and changes that leave its key."""
SCENES: dict[str, dict[str, str]] = {
    **SHIPPED,
    "pa6_calibrated": {"duration": "20 s"},
    "well_b": {"duration": "20 s"},
    "ufrj_rig": {"duration": "20 s"},
    "bha_stress": {"duration": "10 s"},
    "wells/drillbotics": {"duration": "10 s"},
    "wells/vertical_3000": {"duration": "10 s"},
    "wells/s_shaped": {"duration": "10 s"},
}
ACCURACIES = ("5 %", "1 %")
CHOICES = ("pa6_bench", "pa6_calibrated", "bha_full_size")
LENGTH = {"duration": "12 s"}
TRIED = ("5 %", "3 %", "1 %", "0.3 %")
SHARES = (0.125, 0.177, 0.25, 0.354, 0.5, 0.707, 1.0)
"""Elements of the resolutions to choose the cheapest from, over those of `auto`."""
STEPS = (1, 2, 4)
"""Their time steps in a frame."""


def run(scene: str, accuracy: str, changes: dict[str, str]) -> dict[str, Any]:
    """Make a run in a process of its own; returns what its summary says of the accuracy, or its error."""
    with tempfile.TemporaryDirectory() as folder:
        words = [word for key, value in changes.items() for word in ("--set", f"rig.{key}={value}")]
        command = [sys.executable, "-m", "drill_twin.cli", "run", scene, "--accuracy", accuracy, "--no-check", *words]
        done = subprocess.run([*command, "--out", f"{folder}/run"], capture_output=True, text=True, check=False)
        if done.returncode:
            return {"error": (done.stderr.strip().splitlines() or ["?"])[-1]}
        return dict(json.loads(Path(folder, "run", "summary.json").read_text("utf-8"))["accuracy"])


def expected_against_used() -> Iterator[tuple[str, Any]]:
    """Names of the runs and functions that make them, in order."""
    from drill_twin.core.files.kept_files import cache_folder
    from drill_twin.studies.accuracy.error_model import FOLDER

    for scene, changes in SCENES.items():
        for accuracy in ACCURACIES:
            for kind in ("shipped",) if scene in SHIPPED else ("measured", "cached"):

                def made(s: str = scene, a: str = accuracy, c: dict[str, str] = changes, k: str = kind) -> Any:
                    if k != "cached":
                        for file in (cache_folder() / FOLDER).glob("*.json"):
                            file.unlink()
                    return run(s, a, c)

                yield f"{scene} {accuracy} {kind}", made


def choice(scene: str, accuracy: str) -> dict[str, Any]:
    """Effort of the chosen resolution over that of the cheapest whose true error is below the accuracy."""
    from drill_twin.dynamics.twin.twin import Twin
    from drill_twin.scene import load_scene
    from drill_twin.studies.accuracy import resolve

    plan = resolve(load_scene(scene, overrides={**LENGTH, "accuracy": accuracy}))
    own = plan.scene.numerics
    error, effort = tried(scene, int(own.elements), float(own.step), plan.scene.tolerance)
    best, cheapest = effort, (int(own.elements), float(own.step))
    automatic = Twin(load_scene(scene, overrides=LENGTH)).elements
    for count in sorted({max(4, round(share * automatic)) for share in SHARES}):
        for steps in STEPS:
            found, price = tried(scene, count, 0.01 / steps, 1e-4)
            if found <= plan.asked and price < best:
                best, cheapest = price, (count, 0.01 / steps)
    return {
        "asked": plan.asked, "error": error, "elements": own.elements, "step": own.step,
        "cheapest": cheapest, "over": effort / best,
    }  # fmt: skip


@cache
def exact(scene: str) -> Motion:
    """Run of twice the elements of `auto`, with eight steps to a frame."""
    from drill_twin.dynamics.twin.twin import Twin
    from drill_twin.scene import load_scene
    from drill_twin.studies.accuracy.measure import AFTER_ONSET, at
    from drill_twin.studies.accuracy.motion_run import run_motion

    described = load_scene(scene, overrides=LENGTH)
    return run_motion(at(described, 2 * Twin(described).elements, 0.01 / 8, 1e-7), after_onset=AFTER_ONSET)


@cache
def tried(scene: str, elements: int, step: float, tolerance: float) -> tuple[float, float]:
    """True error of a resolution, and its effort."""
    from drill_twin.core.errors import RunError
    from drill_twin.scene import load_scene
    from drill_twin.studies.accuracy.error_model import OVERHEAD
    from drill_twin.studies.accuracy.errors import errors_before
    from drill_twin.studies.accuracy.measure import at
    from drill_twin.studies.accuracy.motion_run import run_motion

    true = exact(scene)
    try:
        described = at(load_scene(scene, overrides=LENGTH), elements, step, tolerance)
        motion = run_motion(described, until=float(true.time[-1]))
    except RunError:
        return 1.0, 0.0
    return max(errors_before(motion, true)), float(motion.iterations.sum()) * (elements + OVERHEAD)


def ship() -> None:
    """Measure the curves of `config/accuracy` anew."""
    from drill_twin.scene import load_scene
    from drill_twin.scene.paths import config_dir
    from drill_twin.studies.accuracy.error_model import FOLDER
    from drill_twin.studies.accuracy.measure import Measurement

    for scene in SHIPPED:
        model = Measurement(load_scene(scene), 1e-3, lambda *_: None).model()
        path = config_dir() / FOLDER / f"{scene}.json"
        model.save(path)
        path.chmod(0o644)
        print(scene, model.key, model.ended)


def main() -> None:
    """Make the runs that the file has not, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for option in ("choice", "ship"):
        parser.add_argument(f"--{option}", action="store_true")
    parser.add_argument("--out", type=Path, default=Path("out/accuracy_cost.jsonl"))
    given = parser.parse_args()
    if given.ship:
        ship()
        return
    kept = JsonLines(given.out, tuple[str, dict[str, Any]], "accuracy_cost", {})
    done = dict(kept.results)
    jobs = (
        [
            (f"{scene} {accuracy} choice", lambda s=scene, a=accuracy: choice(s, a))
            for scene in CHOICES
            for accuracy in TRIED
        ]
        if given.choice
        else list(expected_against_used())
    )
    for name, make in jobs:
        if name not in done:
            done[name] = make()
            kept.add((name, done[name]))
        print(_line(name, done[name]), flush=True)
    times = [one for name, _ in jobs if "expected_seconds" in (one := done[name])]
    near = sum(abs(one["expected_seconds"] / one["actual_seconds"] - 1.0) <= 0.3 for one in times)
    if times:
        print(f"expected within 30 % of used: {near} of {len(times)}")


def _line(name: str, one: dict[str, Any]) -> str:
    if "error" in one and "over" not in one:
        return f"{name:38} {one['error']}"
    if "over" in one:
        count, step = one["cheapest"]
        return (
            f"{name:38} error {one['error'] * 100:.2g} %, {one['elements']} elements, {one['step'] * 1e3:.3g} ms; "
            f"cheapest {count}, {step * 1e3:.3g} ms; {one['over']:.2f} times its effort"
        )
    expected, used = one["expected_seconds"], one["actual_seconds"]
    return (
        f"{name:38} expected {expected:8.3f} s, used {used:8.3f} s, ratio {expected / used:.2f}; "
        f"measuring {one['measuring_seconds']:.2g} s, {one['measuring_seconds'] / used:.1f} times the run"
    )


if __name__ == "__main__":
    main()
