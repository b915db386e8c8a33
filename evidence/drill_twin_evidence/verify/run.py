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
    """Run the cases on several processes.

    Args:
        cases: Cases to run.
        workers: Processes.
        progress: Called with each result as a case ends.

    Returns:
        Results in the order of the cases.
    """
    found = run_jobs(
        _run, {case: (case.name,) for case in cases}, workers,
        done=lambda case, result: progress(CaseResult(case, *result)), kernel=_kernel,
    )  # fmt: skip
    return [CaseResult(case, *result) for case, result in found.items()]


def _kernel(case: Case) -> str:
    """Cases with the same set of effects and the same formulation run nearly always the same compiled code."""
    return f"{TOPICS.get(case.topic, case.topic)}/{case.form}"


def _run(name: str) -> tuple[tuple[Row, ...], float, str]:
    """Rows of the case of this name, the seconds they took, and why there are none; called in a worker process."""
    began = time.perf_counter()
    try:
        rows = tuple({case.name: case for case in all_cases()}[name].run())
    except Exception as error:  # noqa: BLE001  a case that fails is reported in the table; the others go on
        return (), 0.0, f"{type(error).__name__}: {error}"
    return rows, time.perf_counter() - began, "" if rows else "it gave no numbers"
