# SPDX-License-Identifier: Apache-2.0
"""Runs of hard cases, and their assessment."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from drill_twin.core.errors import DrillTwinError
from drill_twin.dynamics.twin.frame import Frames
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.io.messages.encode import RIG_COLUMNS, wall_push
from drill_twin.runs import compile_kernel
from drill_twin.runs.ensemble.parts import frames_of, planned
from drill_twin.studies.pool import run_jobs
from drill_twin_evidence.stress.bound import allowed_depth
from drill_twin_evidence.stress.case import EXPECTED_STOPS, HardCase

ROUNDING = 1e-9
"""Negative dissipation up to this share of the energy in motion counts as round-off."""
MAX_ENERGY_ERROR = 0.1
"""Largest energy error of a valid run, over the energy in motion."""


@dataclass(frozen=True)
class Result:
    """Results of a hard case."""

    name: str
    why: str
    form: str
    elements: int
    step: float
    """Nominal time step [s]."""
    reached: float
    """Simulated time reached [s]."""
    steps: int
    cut_steps: int
    iterations: int
    interventions: int
    """Frames that the step guard rejected and repeated."""
    depth: float
    """Largest penetration of the wall [m]; negative: no contact."""
    allowed: float
    """Penetration that the contact law allows at the speeds of the run [m]."""
    travel: float
    """Displacement in half a step at the largest speed [m]: contact is evaluated once a step."""
    speed: float
    """Largest lateral speed of a node [m/s]."""
    real_time_factor: float
    """Simulated time over wall-clock time, output of frames included."""
    energy: float | None
    """Largest energy error, over the largest energy in motion; None without the audit."""
    verdict: str
    """`ok`, or the reason why the run is not valid."""

    @property
    def ok(self) -> bool:
        """True if the case is in order: run to its end, or stopped for the expected reason."""
        return self.verdict.startswith("ok")

    def to_dict(self) -> dict[str, Any]:
        """Plain types for JSON (`drill_twin.core.files.plain_json`)."""
        return asdict(self) | {"ok": self.ok}


class RunStatistics:
    """Statistics over the frames of a run."""

    def __init__(self) -> None:
        self.steps = self.cut_steps = self.iterations = self.interventions = 0
        self.depth, self.speed, self.finite = -np.inf, 0.0, True
        self.energy: float | None = None
        self.gained = ""  # name of a dissipative effect that added energy

    def add(self, frames: Frames) -> None:
        """Add frames; of their energy balances, that of the last."""
        self.steps += frames.stats.steps
        self.cut_steps += frames.stats.cut_steps
        self.iterations += frames.stats.iterations
        self.interventions += len(frames.interventions)
        self.depth = max(self.depth, float(frames.wall_depth.max()))
        marks = frames.marks
        parts = (frames.u, frames.v, frames.tangents, frames.wall_force, *marks, frames.rig[:, RIG_COLUMNS],
                 wall_push(marks.centre, marks.wall_force))  # as published  # fmt: skip
        self.finite = self.finite and all(bool(np.isfinite(part).all()) for part in parts if part is not None)
        if frames.v is not None:
            self.speed = max(self.speed, float(np.linalg.norm(frames.v[..., :2], axis=-1).max()))
        if frames.energy is not None:
            self.energy = max(self.energy or 0.0, abs(frames.energy.share))
            least = -ROUNDING * frames.energy.scale
            self.gained = self.gained or next((k for k, heat in frames.energy.dissipated.items() if heat < least), "")


def run_hard(
    cases: Sequence[HardCase],
    *,
    workers: int = 2,
    energy: bool = False,
    progress: Callable[[Result], None] = lambda _: None,
) -> list[Result]:
    """Run the cases on several processes, the longest first.

    The forms of a scene follow each other, so that two workers compile two kernels.

    Args:
        cases: What to run.
        workers: Processes.
        energy: Whether to audit the energy, which takes kernels of its own.
        progress: Called with each result as a case ends.

    Returns:
        Results in the order of the cases.
    """
    ordered = sorted(cases, key=lambda case: -case.seconds if case.long else 0.0)
    jobs = {case: (case, energy) for case in ordered}
    found = run_jobs(run_case, jobs, workers, done=lambda _, result: progress(result))
    return [found[case] for case in cases]


def run_case(case: HardCase, energy: bool = False) -> Result:
    """Run a case, with the energy audit if `energy`; a run that stops or cannot begin is a result."""
    try:
        scene = case.scene(energy=energy)
        compile_kernel(scene, scene.numerics.frame_period)  # before the timing starts
        twin, found, stopped = Twin(scene), RunStatistics(), ""
    except DrillTwinError as error:
        nothing = (0, 0.0, 0.0, 0, 0, 0, 0, -np.inf, 0.0, 0.0, 0.0, 0.0, None)
        return Result(case.name, case.why, case.form, *nothing, verdict_on(case, RunStatistics(), str(error), 0.0))
    began = time.perf_counter()
    try:
        for frames in frames_of(twin, *planned(scene), 1 if energy else None):
            found.add(frames)
    except DrillTwinError as error:
        stopped = str(error)
    seconds = time.perf_counter() - began
    allowed, travel = allowed_depth(twin, found.speed), 0.5 * twin.step_size * found.speed
    return Result(
        case.name, case.why, case.form, twin.elements, twin.step_size, twin.time, found.steps, found.cut_steps,
        found.iterations, found.interventions, found.depth, allowed, travel, found.speed, twin.time / seconds,
        found.energy, verdict_on(case, found, stopped, allowed + travel),
    )  # fmt: skip


def verdict_on(case: HardCase, found: RunStatistics, stopped: str, allowed: float) -> str:
    """`ok`, or the reason why a run is not valid."""
    must_say = EXPECTED_STOPS.get(case.scene_name)
    if stopped and must_say and must_say in stopped:
        return f"ok, stopped: {stopped}"
    if stopped:
        return f"stopped: {stopped}"
    if must_say:
        return f'expected it to stop and say "{must_say}", found a run to its end'
    if not found.finite:
        return "the state is not finite"
    if found.gained:
        return f"{found.gained} added energy to the string, expected only dissipation"
    if found.energy is not None and found.energy > MAX_ENERGY_ERROR:
        return f"{found.energy:.0%} of the energy in motion is an error of the energy balance"
    if found.depth > allowed:
        return f"{found.depth * 1e3:.3g} mm into the wall, expected at most {allowed * 1e3:.3g} mm"
    return "ok"
