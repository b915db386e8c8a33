# SPDX-License-Identifier: Apache-2.0
"""Outcomes as rows of plain numbers: errors, real-time factors, what went wrong."""

from __future__ import annotations

import platform
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from drill_twin_evidence.benchmarks.peers.parts import Part
from drill_twin_evidence.benchmarks.peers.rod import rod_of
from drill_twin_evidence.benchmarks.peers.run import Outcome, versions
from drill_twin_evidence.benchmarks.peers.task import Motion, Task


def contact_time(task: Task, motion: Motion) -> float:
    """Time at which the rod first touches the wall [s]; infinite without a wall or contact."""
    law = rod_of(task).law
    touching = np.flatnonzero(motion.reach > law[0]) if law is not None else np.empty(0)
    return float(motion.time[touching[0]]) if touching.size else np.inf


def path_error(motion: Motion, reference: Motion, until: float) -> float | None:
    """Largest distance from the reference's mid-span path up to a time [s], over the path's largest value [-]."""
    frames = int(np.sum(reference.time < until))
    if motion.time.size < frames:
        return None
    apart = np.hypot(*(motion.path[:frames] - reference.path[:frames]).T)
    return float(apart.max() / np.hypot(*reference.path[:frames].T).max())


def row(outcome: Outcome, reference: Motion | None, until: float) -> dict[str, Any]:
    """One line of a table."""
    task, motion = outcome.task, outcome.motion
    step_ms = motion_step(motion, task)
    late = motion.time > 0.5 * motion.time[-1] if motion.time.size else motion.time > 0.0
    return {
        "tool": task.tool,
        "scene": task.scene,
        "plain": bool(task.options.get("plain")),
        "elements": task.elements,
        "step_ms": step_ms,
        "error": path_error(motion, reference, until) if reference is not None else None,
        "cost": outcome.cost if np.isfinite(outcome.cost) else None,
        "costs": [cost for cost in outcome.costs if np.isfinite(cost)],
        "element_step_ns": outcome.cost * step_ms * 1e6 / task.elements if step_ms and motion.time.size else None,
        "reached_s": float(motion.time[-1]) if motion.time.size else 0.0,
        "mean_rise_m": float(motion.bottom[late].mean()) if late.any() else None,
        "largest_reach_m": float(motion.reach.max()) if motion.time.size else None,
        "failure": motion.failure,
    }


def motion_step(motion: Motion, task: Task) -> float | None:
    """Mean step that was taken [ms]."""
    return float(motion.time[-1] / motion.steps * 1e3) if motion.steps and motion.time.size else task.step * 1e3 or None


def result(
    part: Part, outcomes: Sequence[Outcome], reference: Motion | None, check: Motion | None, rounds: int
) -> dict[str, Any]:
    """All that is known of a part, for JSON."""
    until = contact_time(part.reference, reference) if part.reference and reference is not None else np.inf
    return {
        "part": part.name,
        "title": part.title,
        "rounds": rounds,
        "machine": {"processor": processor(), "python": platform.python_version()},
        "versions": versions(sorted({outcome.task.tool for outcome in outcomes})),
        "contact_s": until if np.isfinite(until) else None,
        "reference": part.reference.label if part.reference else None,
        "apart": path_error(check, reference, until) if check is not None and reference is not None else None,
        "check": part.check.label if part.check and check is not None else None,
        "rows": [row(outcome, reference, until) for outcome in outcomes],
    }


def processor() -> str:
    """Name of the processor, as the system has it."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text().splitlines() if info.is_file() else []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor()
