# SPDX-License-Identifier: Apache-2.0
"""Processor time of the studies that run many scenes, of this tree and of an earlier one, and whether figures differ.

    git worktree add ../before REVISION
    python -m benchmarks.study_cost ../before

Each study at a small size, with one worker, its start included. Each round measures both trees in turn, each study in a
process of its own; the least of all rounds counts. A first round, which may compile kernels, is left out.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import resource
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parents[1]
LATERAL = {"effects.stretch": "off", "effects.torsion": "off"}
FEW = dict.fromkeys(("bit_friction", "bow", "drag", "eccentricity", "gravity", "stretch", "torsion"), "off")
HARD = ("elements_5", "friction_2", "load_300_n", "level_hole")
MEASURED = frozenset((
    "cost", "realtime_factor", "frame_p95", "compile_seconds", "on_front", "error_model", "cost_share",
    "iteration_share", "iteration_cost", "real_time_factor", "version",
))  # fmt: skip
"""Fields that are times, or follow from times."""
ROUNDING = 1e-12
"""Relative difference of two numbers that are the same but for rounding."""


def cost() -> Any:
    """Six runs of `pa6_bench` with 6 to 24 elements."""
    from drill_twin.studies.convergence.curve import Resolution, measure

    resolutions = [Resolution("spatial", count, 0.01) for count in (6, 8, 12)]
    with tempfile.TemporaryDirectory() as folder:
        return measure("pa6_bench", {}, resolutions, Path(folder), replicas=2, workers=1).to_dict()


def effects() -> Any:
    """Sets of four effects of `pa6_bench`, five runs of 15 s each."""
    from drill_twin.studies.ablation import ablate

    off = {f"effects.{key}": value for key, value in FEW.items()}
    return ablate("pa6_bench", {**off, "duration": "15"}, tolerance=0.05, replicas=5, workers=1).to_dict()


def paper() -> Any:
    """The bench of the paper, 15 runs of 30 s with 12 elements."""
    from drill_twin.scene import load_scene
    from drill_twin.studies.paper.runs.reproduction import reproduce

    scene = load_scene("pa6_calibrated", overrides={"numerics.elements": "12", "duration": "30"})
    return reproduce(scene, processes=1, variants=False, full_size_too=False).to_dict()


def calibrate() -> Any:
    """Examination of the bench, 250 runs of 4 s with 8 elements."""
    from drill_twin.scene import load_scene
    from drill_twin.studies.paper.calibration.calibrate import calibrate as search

    scene = load_scene("pa6_calibrated", overrides=LATERAL | {"numerics.elements": "8", "duration": "4"})
    found = search(scene, seed=1, population=5, generations=0, processes=1, progress=lambda *_: None)
    return [vars(loss) for loss in found.tried]


def score() -> Any:
    """Score of the analyzer on 12 records, 7 of them simulated."""
    from drill_twin.studies.detection.measure import Plan, measure

    return measure(Plan(kinematic=4, still=1, bench=4, drawn=2, bouncing=1, hours=0.1), workers=1).to_dict()


def hard() -> Any:
    """Eight hard cases."""
    from drill_twin.studies.stress import all_hard_cases, run_hard

    cases = [case for case in all_hard_cases() if case.name.partition("[")[0] in HARD]
    return [result.to_dict() for result in run_hard(cases, workers=1)]


STUDIES: dict[str, Callable[[], Any]] = {
    "`cost`, 6 runs": cost, "`effects`, 4 sets": effects, "`paper`, 15 runs": paper, "`calibrate`, 250 runs": calibrate,
    "`analyzer-score`, 12 records": score, "`hard`, 8 cases": hard,
}  # fmt: skip


def main() -> None:
    """Measure both trees and print the ratios."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("before", type=Path, help="folder of the earlier tree; - measures this process")
    parser.add_argument("--rounds", type=int, default=2)
    parser.add_argument("--only", choices=[function.__name__ for function in STUDIES.values()])
    given = parser.parse_args()
    if str(given.before) == "-":
        print(json.dumps(measured(next(each for each in STUDIES.values() if each.__name__ == given.only))))
        return
    print("| study | before, s | now, s | ratio | figures |\n| --- | --- | --- | --- | --- |")
    for name, study in STUDIES.items():
        if given.only in {None, study.__name__}:
            print(f"| {name} | {row(study, given.before.resolve(), given.rounds)} |", flush=True)


def row(study: Callable[[], Any], before: Path, rounds: int) -> str:
    """Cells of a study: least processor times, their ratio, and whether all figures are the same."""
    found: dict[Path, Any] = {}
    least = {before: math.inf, HERE: math.inf}
    for number in range(rounds + 1):
        for tree in (before, HERE):
            seconds, found[tree] = _in_child(study.__name__, tree)
            least[tree] = min(least[tree], seconds if number else math.inf)
    then, now = least.values()
    word = "the same" if same(found[before], found[HERE]) else "differ"
    return f"{then:.1f} | {now:.1f} | {then / now:.1f} | {word}"


def _in_child(name: str, tree: Path) -> tuple[float, Any]:
    environment = os.environ | {"PYTHONPATH": str(tree), "OMP_NUM_THREADS": "1"}
    command = [sys.executable, __file__, "-", "--only", name]
    printed = subprocess.run(command, env=environment, check=True, stdout=subprocess.PIPE).stdout
    seconds, figures = json.loads(printed.splitlines()[-1])
    return seconds, figures


def measured(study: Callable[[], Any]) -> tuple[float, Any]:
    """Processor time of a study and its worker processes [s], and its figures."""
    import drill_twin.studies.pool  # noqa: F401 - as the command has imported it before

    began = _processor_time()
    figures = study()
    return _processor_time() - began, figures


def _processor_time() -> float:
    used = [resource.getrusage(which) for which in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(each.ru_utime + each.ru_stime for each in used)


def same(one: Any, other: Any) -> bool:
    """Return True if figures are the same, but for what is measured, and for rounding."""
    if isinstance(one, dict) and isinstance(other, dict):
        keys = (one.keys() | other.keys()) - MEASURED
        return all(key in one and key in other and same(one[key], other[key]) for key in keys)
    if isinstance(one, list) and isinstance(other, list):
        return len(one) == len(other) and all(map(same, one, other))
    if isinstance(one, float) and isinstance(other, float):
        return one == other or math.isclose(one, other, rel_tol=ROUNDING) or (math.isnan(one) and math.isnan(other))
    return bool(one == other)


if __name__ == "__main__":
    main()
