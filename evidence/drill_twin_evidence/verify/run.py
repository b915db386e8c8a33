# SPDX-License-Identifier: Apache-2.0
"""Runs of cases on several processes."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from drill_twin.studies.pool import run_jobs
from drill_twin_evidence.verify import TOPICS, all_cases
from drill_twin_evidence.verify.case import Case
from drill_twin_evidence.verify.row import Row


@dataclass(frozen=True)
class CaseResult:
    """Rows of a case, or the reason why there are none."""

    case: Case
    rows: tuple[Row, ...]
    seconds: float
    """Wall-clock time, with compiling [s]."""
    failure: str = ""
    """Reason why there are no rows; empty if there are."""

    @property
    def ok(self) -> bool:
        """True if the case ran and every row is within its tolerance."""
        return not self.failure and bool(self.rows) and all(row.ok for row in self.rows)

    def to_dict(self) -> dict[str, Any]:
        """Plain types for JSON."""
        return {
            "case": self.case.name,
            "form": self.case.form,
            "ok": self.ok,
            "failure": self.failure,
            "rows": [row.to_dict() for row in self.rows],
        }


def run_cases(
    cases: Sequence[Case], *, workers: int = 2, progress: Callable[[CaseResult], None] = lambda _: None
) -> list[CaseResult]:
    """Run the cases on several processes; those of one kernel are one job, so that it is compiled or loaded once.

    Args:
        cases: Cases to run.
        workers: Processes.
        progress: Called with each result as the cases of a kernel end.

    Returns:
        Results in the order of the cases.
    """
    groups = dict[str, list[Case]]()
    for case in cases:
        groups.setdefault(_kernel(case), []).append(case)
    results = dict[Case, CaseResult]()

    def ended(kernel: str, found: Sequence[tuple[tuple[Row, ...], float, str]]) -> None:
        for case, result in zip(groups[kernel], found, strict=True):
            results[case] = CaseResult(case, *result)
            progress(results[case])

    run_jobs(
        _run, {kernel: ([case.name for case in members],) for kernel, members in groups.items()}, workers, done=ended
    )
    return [results[case] for case in cases]


def _kernel(case: Case) -> str:
    """Cases with the same set of effects and the same formulation run nearly always the same compiled code."""
    return f"{TOPICS.get(case.topic, case.topic)}/{case.form}"


def _run(names: Sequence[str]) -> list[tuple[tuple[Row, ...], float, str]]:
    """Of each case its rows, the seconds they took, and why there are none; called in a worker process."""
    known = {case.name: case for case in all_cases()}
    found: list[tuple[tuple[Row, ...], float, str]] = []
    for name in names:
        began = time.perf_counter()
        try:
            rows = tuple(known[name].run())
        except Exception as error:  # noqa: BLE001  a case that fails is reported in the table; the others go on
            found.append(((), 0.0, f"{type(error).__name__}: {error}"))
            continue
        found.append((rows, time.perf_counter() - began, "" if rows else "it gave no numbers"))
    return found
