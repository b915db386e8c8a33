# SPDX-License-Identifier: Apache-2.0
"""Accuracy of `drill-twin run`: choice of the resolution before the run, check after it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from drill_twin.accuracy import Plan
    from drill_twin.report.recording import Recording
    from drill_twin.scene import Scene


def planned(scene: Scene) -> Plan:
    """Choose the resolution, with a progress bar where a cost curve must be measured, and print the expected error."""
    from rich.progress import Progress

    from drill_twin.accuracy import resolve
    from drill_twin.accuracy.error_model import load_model
    from drill_twin.cli.show import err

    console = err()
    if load_model(scene) is None:
        console.print("no cost curve of this scene yet: measuring a small one", markup=False, soft_wrap=True)
    with Progress(console=console, transient=True) as bar:
        task = bar.add_task("reading the cost curve", total=1.0)
        plan = resolve(scene, progress=lambda line, share: bar.update(task, completed=share, description=line))
    console.print(plan.sentence, markup=False, soft_wrap=True)
    return plan


def checked(plan: Plan, recording: Recording, *, rerun: bool) -> dict[str, Any]:
    """Compare a run with its plan, print the result, and return it for the summary."""
    from rich.progress import Progress

    from drill_twin.accuracy import check
    from drill_twin.cli.show import err

    console = err()
    with Progress(console=console, transient=True) as bar:
        task = bar.add_task("checking: the part before the onset at a finer resolution", total=recording.duration)
        result = check(plan, recording, rerun=rerun, progress=lambda time: bar.update(task, completed=time))
    actual = "not checked" if result.actual is None else f"{result.actual * 100:.2g} %"
    console.print(
        f"error before the onset: {actual}, expected {result.expected * 100:.2g} %, asked {result.asked * 100:g} %; "
        f"computing: {result.actual_seconds:.2g} s by the clock, {result.expected_seconds:.2g} s of a core expected",
        markup=False,
        soft_wrap=True,
    )
    return result.to_dict()
