# SPDX-License-Identifier: Apache-2.0
"""Run hard cases on several processors."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context

from drill_twin.studies.stress.case import HardCase
from drill_twin.studies.stress.judge import Result, run_case


def run_hard(
    cases: Sequence[HardCase],
    *,
    workers: int = 2,
    energy: bool = False,
    progress: Callable[[Result], None] = lambda _: None,
) -> list[Result]:
    """Run the cases, the longest first; the forms of a scene follow each other, so that two workers compile two things.

    Args:
        cases: What to run.
        workers: Processes.
        energy: Whether to audit the energy, which takes kernels of its own.
        progress: Called with each result as it comes.

    Returns:
        Results in the order of the cases.
    """
    found: dict[str, Result] = {}
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:  # a forked numba would share its locks
        ordered = sorted(cases, key=lambda case: -case.seconds if case.long else 0.0)
        for future in as_completed([pool.submit(run_case, case, energy=energy) for case in ordered]):
            result = future.result()
            found[result.name] = result
            progress(result)
    return [found[case.name] for case in cases]
