# SPDX-License-Identifier: Apache-2.0
"""Runs of the study: every labelled set through the analyzer, and its scores."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

from drill_twin.studies.pool import run_jobs
from drill_twin_evidence.detection.cases import BENCH, bench, bouncing, recorded, simulated
from drill_twin_evidence.detection.ground_truth import truth_of
from drill_twin_evidence.detection.runs import Run
from drill_twin_evidence.detection.scoring import STATES, Score, analyse, f1_scores, macro_f1
from drill_twin_evidence.detection.signals import Record, labelled, steady
from drill_twin_evidence.detection.steady import false_onsets

HELD_OUT = 1000
"""First seed of records that no threshold was chosen on; the analyzer was made on those below 300."""


@dataclass(frozen=True)
class Plan:
    """Size of the study."""

    kinematic: int = 300
    """Labelled kinematic records."""
    still: int = 60
    """Kinematic records of steady rotation with noise of 5 % of the clearance."""
    bench: int = len(BENCH)
    """Simulated runs of the paper's bench."""
    drawn: int = 36
    """Simulated runs with random parameters."""
    bouncing: int = 8
    """Simulated runs of a string that bounces between the walls."""
    hours: float = 24.0
    """Steady rotation at 20 Hz [h]."""
    first_seed: int = HELD_OUT
    """Seed of the first of the drawn records."""


QUICK = Plan(kinematic=24, still=6, bench=4, drawn=4, bouncing=1, hours=0.25)
"""A tenth of it, for a quick check."""


@dataclass
class Result:
    """Scores of the study."""

    plan: Plan
    kinematic: Score = field(default_factory=Score)
    simulated: Score = field(default_factory=Score)
    """Simulated runs, from wall marks, spin and top speed alone."""
    with_forces: Score = field(default_factory=Score)
    """Simulated runs, with the wall forces at the marks too."""
    false_onsets: int = 0
    """Marks with an onset in the hours of steady rotation."""
    worst: list[tuple[float, str]] = field(default_factory=list)
    """Onsets beyond the tolerance: error [rev] and record."""

    def to_dict(self) -> dict[str, Any]:
        """Plain types for JSON."""
        sets = {"kinematic": self.kinematic, "simulated": self.simulated, "simulated_with_forces": self.with_forces}
        return {
            "plan": vars(self.plan),
            "sets": {name: _plain(score) for name, score in sets.items()},
            "false_onsets": self.false_onsets,
            "not_met": [{"error_rev": error, "record": name} for error, name in self.worst],
        }


def measure(plan: Plan, *, workers: int = 1, progress: Callable[[str], None] = lambda _: None) -> Result:
    """Make and analyse every record of a plan, on several processes, and merge the scores."""
    result = Result(plan)
    jobs = {job: (plan, *job) for job in _jobs(plan)}
    for name, found in run_jobs(_one, jobs, workers, done=lambda _, named: progress(named[0])).values():
        if isinstance(found, int):
            result.false_onsets = found
            continue
        for kind, score in found:
            getattr(result, kind).merge(score)
            result.worst += [(error, name) for error in score.onset_error if abs(error) > 0.5 and kind != "with_forces"]
    return result


def _jobs(plan: Plan) -> Iterator[tuple[str, int]]:
    if plan.hours:
        yield "hours", 0
    for kind in ("bouncing", "bench", "drawn", "kinematic", "still"):
        yield from ((kind, number) for number in range(getattr(plan, kind)))


def _one(plan: Plan, kind: str, number: int) -> tuple[str, list[tuple[str, Score]] | int]:
    """Name and scores of a record, or name and number of false onsets of the steady rotation."""
    if kind == "hours":
        return "steady rotation", false_onsets(plan.hours)
    if kind in {"kinematic", "still"}:
        record = (labelled if kind == "kinematic" else steady)(plan.first_seed + number)
        return record.name, [("kinematic", _scored(record, states=kind == "kinematic"))]
    simulations: dict[str, Callable[[int], Run]] = {"bouncing": bouncing, "bench": bench, "drawn": simulated}
    run = simulations[kind](number if kind == "bench" else plan.first_seed + number)
    seen = partial(recorded, run, truth_of(run))
    return run.name, [
        ("simulated", _scored(seen(forces=False))),
        ("with_forces", _scored(seen(forces=True))),
    ]


def _scored(record: Record, *, states: bool = True) -> Score:
    score = Score()
    score.add(record.truth, analyse(record), record.rotation)
    if not states:
        score.string[:] = 0
        score.marks[:] = 0
    return score


def _plain(score: Score) -> dict[str, Any]:
    error, delay = np.array(score.onset_error), np.array(score.delay)
    return {
        "records": score.records,
        "onsets": score.onsets,
        "met": score.met,
        "missed": score.missed,
        "false": score.false,
        "median_error_rev": float(np.median(np.abs(error))) if error.size else None,
        "median_delay_rev": float(np.median(delay)) if delay.size else None,
        "delay_95_rev": float(np.percentile(delay, 95)) if delay.size else None,
        "string_macro_f1": macro_f1(score.string) if score.string.any() else None,
        "string_f1": f1_scores(score.string),
        "string_confusion": score.string.tolist(),
        "marks_macro_f1": macro_f1(score.marks) if score.marks.any() else None,
        "marks_f1": f1_scores(score.marks),
        "marks_confusion": score.marks.tolist(),
        "states": list(STATES),
    }
