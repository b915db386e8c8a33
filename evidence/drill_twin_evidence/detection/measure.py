# SPDX-License-Identifier: Apache-2.0
"""Scores and curves of the analyzer and of the plain detector on the frozen records, and their tables."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from drill_twin.core.table import Table
from drill_twin.studies.pool import run_jobs
from drill_twin_evidence.detection.frozen import KINDS, FrozenScore, by_analyzer, frozen_records, score_of
from drill_twin_evidence.detection.frozen.curves import Curves, curves_of, rows_of
from drill_twin_evidence.detection.frozen.score import STATES, Detector, macro_f1
from drill_twin_evidence.detection.frozen.truth import NEW
from drill_twin_evidence.detection.plain import plain

DETECTORS: Mapping[str, Detector] = {"analyzer": by_analyzer, "plain": plain}


class Plan(NamedTuple):
    """Size of the study."""

    share: int = 1
    """Every so-manieth frozen record."""
    hours: float = 3.0
    """Noise alone, at each level [h]."""
    each: int = 8
    """Records at each point of the other curves."""


QUICK = Plan(10, 0.1, 1)


@dataclass
class Result:
    """Scores by detector and kind of record, and curves by detector."""

    plan: Plan
    scores: dict[str, dict[str, FrozenScore]] = field(default_factory=dict)
    curves: dict[str, Curves] = field(default_factory=dict)

    def to_dict(self) -> dict[str, Any]:
        """Plain types for JSON."""
        return {
            "plan": self.plan._asdict(),
            "scores": {name: {kind: one.plain() for kind, one in kinds.items()} for name, kinds in self.scores.items()},
            "curves": {name: one.plain() for name, one in self.curves.items()},
        }


def measure(plan: Plan, *, workers: int = 1, progress: Callable[[str], None] = lambda _: None) -> Result:
    """Score both detectors on every frozen record of a plan, on several processes, and measure their curves."""
    result = Result(plan)
    jobs = {(name, kind): (plan, name, kind) for name in DETECTORS for kind in (*reversed(KINDS), "curves")}
    found = run_jobs(_one, jobs, workers, done=lambda key, _: progress(" ".join(key)))
    for name in DETECTORS:
        kinds: dict[str, FrozenScore] = {}
        for kind in KINDS:
            for key in (kind, *(("all",) if kind != "s" else ())):
                kinds.setdefault(key, FrozenScore()).merge(found[name, kind])
        result.scores[name] = kinds
        result.curves[name] = found[name, "curves"]
    return result


def _one(plan: Plan, name: str, kind: str) -> Any:
    if kind == "curves":
        return curves_of(DETECTORS[name], plan.hours, plan.each)
    return score_of(frozen_records(kind, share=plan.share), DETECTORS[name]).get(kind, FrozenScore())


def markdown(result: Result) -> str:
    """Tables of `evidence/docs/detection.md`; cells with a stroke: analyzer / plain detector."""
    return "\n".join([*_onsets(result), "", *_states(result), "", *_curves(result)])


def _onsets(result: Result) -> Iterator[str]:
    heads = (
        "kind", "records", "onsets", "within half a revolution", "within one", "missed", "without whirl", "false",
        "ratio error, median and 95 %", "F1 string", "F1 string, old states", "F1 marks", "F1 marks, old states",
    )  # fmt: skip
    rows = []
    for kind in (*(key for key in KINDS if key != "s"), "all", "s"):
        pair = [result.scores[name][kind] for name in DETECTORS]
        first = pair[0]

        def both(cell: Callable[[FrozenScore], object], pair: list[FrozenScore] = pair) -> str:
            return " / ".join(str(cell(score)) for score in pair)

        rows.append((
            KINDS.get(kind, "all kinematic"), first.records, first.onsets, both(lambda one: one.met(0.5)),
            both(lambda one: one.met(1.0)), both(lambda one: len(one.missed)), first.still + len(first.synchronous),
            both(lambda one: len(one.false)), both(_ratio), both(lambda one: _number(macro_f1(one.string))),
            both(lambda one: _number(macro_f1(one.string, new=False))), both(lambda one: _number(macro_f1(one.marks))),
            both(lambda one: _number(macro_f1(one.marks, new=False))),
        ))  # fmt: skip
    yield Table(heads, rows).markdown()


def _states(result: Result) -> Iterator[str]:
    heads = ("F1 of", "kinematic: string", "marks", "simulated: string", "marks")
    rows = []
    plain_scores = {name: {kind: one.plain() for kind, one in kinds.items()} for name, kinds in result.scores.items()}
    for state in STATES:
        cells = [
            " / ".join(_number(plain_scores[name][kind][level].get(state)) for name in DETECTORS)
            for kind in ("all", "s") for level in ("string_f1", "marks_f1")
        ]  # fmt: skip
        if any(cell.strip("- /") for cell in cells):
            rows.append((state + (" (new)" if state in NEW else ""), *cells))
    yield Table(heads, rows).markdown()


def _curves(result: Result) -> Iterator[str]:
    pair = [list(rows_of(result.curves[name])) for name in DETECTORS]
    for (title, heads, own), (_, _, other) in zip(*pair, strict=True):
        yield f"{title}:\n"
        rows = [
            (mine[0], *(f"{a} / {b}" for a, b in zip(mine[1:], peer[1:], strict=True)))
            for mine, peer in zip(own, other, strict=True)
        ]
        yield Table(heads, rows).markdown()
        yield ""


def _ratio(score: FrozenScore) -> str:
    size = np.abs(score.ratio_error)
    return f"{np.median(size):.2g}, {np.percentile(size, 95):.2g}" if size.size else "-"


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.3f}"
