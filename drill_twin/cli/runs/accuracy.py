# SPDX-License-Identifier: Apache-2.0
"""Accuracy of `drill-twin run`: choice of the resolution before the run, check after it."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from drill_twin.report.recording import Recording
    from drill_twin.scene import Scene
    from drill_twin.studies.accuracy import Plan


def planned(scene: Scene, show: Callable[[str], None]) -> Plan:
    """Choose the resolution and print the expected error; `show` takes the progress in words."""
    from drill_twin.cli.show import remark
    from drill_twin.studies.accuracy import resolve
    from drill_twin.studies.accuracy.progress import in_words

    plan = resolve(scene, progress=in_words(show), compiling=show)
    remark(plan.sentence)
    return plan


def checked(plan: Plan, recording: Recording, motion_seconds: float, *, rerun: bool) -> dict[str, Any]:
    """Compare a run with its plan, print the result, and return it for the summary."""
    from drill_twin.cli.progress import shown_progress
    from drill_twin.cli.show import remark
    from drill_twin.studies.accuracy import check

    what = "checking: the part before the onset at a finer resolution"
    with shown_progress(what, recording.duration, unit="s") as bar:
        result = check(plan, recording, motion_seconds, rerun=rerun, progress=lambda time: bar.show(what, time))
    actual = "not checked" if result.actual is None else f"{result.actual * 100:.2g} %"
    remark(
        f"error before the onset: {actual}, expected {result.expected * 100:.2g} %, asked {result.asked * 100:g} %; "
        f"processor time of the motion: {result.actual_seconds:.2g} s, expected {result.expected_seconds:.2g} s"
        f"{f'; of the check: {result.check_seconds:.2g} s' if rerun else ''}"
    )
    return result.to_dict()
