# SPDX-License-Identifier: Apache-2.0
"""Run cases on several processors and gather what they found."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from contextlib import ExitStack
from dataclasses import dataclass
from multiprocessing import get_context
from typing import Any

from drill_twin.studies.verify import TOPICS, all_cases
from drill_twin.studies.verify.case import Case
from drill_twin.studies.verify.row import Row


@dataclass(frozen=True)
class Outcome:
    """What one case showed."""

    case: Case
    rows: tuple[Row, ...]
    seconds: float
    """Time it took, compiling included [s]."""
    failure: str = ""
    """Why there are no rows; empty if there are."""

    @property
    def ok(self) -> bool:
        """Whether it ran and every row holds."""
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
    cases: Sequence[Case], *, workers: int = 2, progress: Callable[[Outcome], None] = lambda _: None
) -> list[Outcome]:
    """Run the cases, each worker keeping to one compiled kernel as long as there is work for it.

    Args:
        cases: What to run.
        workers: Processes.
        progress: Called with each outcome as it comes.

    Returns:
        Outcomes in the order of the cases.
    """
    left = list(cases)
    last = [""] * workers
    found: dict[str, Outcome] = {}
    context = get_context("spawn")  # a forked numba would share its locks
    with ExitStack() as stack:
        pools = [stack.enter_context(ProcessPoolExecutor(1, mp_context=context)) for _ in range(workers)]
        running: dict[Future[tuple[tuple[Row, ...], float]], tuple[int, Case]] = {}

        def begin(worker: int) -> None:
            case = left.pop(_next(left, last[worker], [*last[:worker], *last[worker + 1 :]]))
            last[worker] = _kernel(case)
            running[pools[worker].submit(_run, case.name)] = (worker, case)

        for worker in range(min(workers, len(left))):
            begin(worker)
        while running:
            for future in wait(running, return_when=FIRST_COMPLETED).done:
                worker, case = running.pop(future)
                error = future.exception()
                rows, seconds = ((), 0.0) if error else future.result()
                failure = f"{type(error).__name__}: {error}" if error else "" if rows else "it gave no numbers"
                found[case.name] = Outcome(case, rows, seconds, failure)
                progress(found[case.name])
                if left:
                    begin(worker)
    return [found[case.name] for case in cases]


def _kernel(case: Case) -> str:
    """Cases with the same answer run the same compiled code, by and large."""
    return f"{TOPICS.get(case.topic, case.topic)}/{case.form}"


def _next(left: Sequence[Case], own: str, others: Sequence[str]) -> int:
    """Index of the case to run next: of the worker's own kernel, else of one that nobody else is at."""
    for index, case in enumerate(left):
        if _kernel(case) == own:
            return index
    return next((index for index, case in enumerate(left) if _kernel(case) not in others), 0)


def _run(name: str) -> tuple[tuple[Row, ...], float]:
    """Rows of the case of this name and the seconds they took; runs in a process of its own."""
    began = time.perf_counter()
    case = {case.name: case for case in all_cases()}[name]
    return tuple(case.run()), time.perf_counter() - began
