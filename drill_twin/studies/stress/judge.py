# SPDX-License-Identifier: Apache-2.0
"""One hard case, run to its end and judged."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from drill_twin.errors import RunError
from drill_twin.schedule import Schedule
from drill_twin.studies.pool import run_jobs
from drill_twin.studies.stress.bound import deepest_allowed
from drill_twin.studies.stress.case import STOPS, HardCase
from drill_twin.twin.frame import Frame
from drill_twin.twin.twin import Twin

ROUNDING = 1e-9
"""Of the energy on the move: dissipation is not called negative within it."""
UNACCOUNTED = 0.1
"""Of the energy on the move, beyond which a run is not right any more."""


@dataclass(frozen=True)
class Result:
    """What a hard case showed."""

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
    """Frames that the guard took back and had done again."""
    depth: float
    """Deepest penetration of the wall [m]; negative: never on it."""
    allowed: float
    """Depth that the law of the wall allows at the speeds that occurred [m]."""
    travel: float
    """How far a node goes in half a step at the largest speed [m]: a long step meets the wall only at its ends."""
    speed: float
    """Largest speed of a node across the hole [m/s]."""
    real_time_factor: float
    """Simulated over wall-clock seconds, frames included."""
    energy: float | None
    """Largest energy that nothing accounts for, over the largest on the move; None without the audit."""
    verdict: str
    """`ok`, or what is wrong."""

    @property
    def ok(self) -> bool:
        """Whether the case is in order: followed to the end, or stopped for the reason it must stop for."""
        return self.verdict.startswith("ok")

    def to_dict(self) -> dict[str, Any]:
        """Plain types for JSON (`drill_twin.studies.json_io`)."""
        return asdict(self) | {"ok": self.ok}


class Watch:
    """What is kept of the frames."""

    def __init__(self) -> None:
        self.steps = self.cut_steps = self.iterations = self.interventions = 0
        self.depth, self.speed, self.finite = -np.inf, 0.0, True
        self.energy: float | None = None
        self.gained = ""  # from the dissipation of an effect that should have none

    def see(self, frame: Frame) -> None:
        """Count a frame."""
        self.steps += frame.stats.steps
        self.cut_steps += frame.stats.cut_steps
        self.iterations += frame.stats.iterations
        self.interventions += frame.intervention is not None
        self.depth = max(self.depth, frame.wall_depth)
        self.speed = max(self.speed, float(np.linalg.norm(frame.velocities[:, :2], axis=1).max()))
        parts = (frame.positions, frame.velocities, frame.tangents, frame.spin, frame.spin_rate, frame.wall_force)
        self.finite = self.finite and all(bool(np.isfinite(part).all()) for part in parts)
        if frame.energy is not None:
            self.energy = max(self.energy or 0.0, abs(frame.energy.share))
            least = -ROUNDING * frame.energy.scale
            self.gained = self.gained or next((k for k, heat in frame.energy.dissipated.items() if heat < least), "")


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
    """Run a case, with the energy audit if asked for; a run that stops is a finding, not an error."""
    scene = case.scene(energy=energy)
    schedule = Schedule.from_scene(scene)
    period = 1.0 / scene.numerics.frame_rate
    Twin(scene).advance(schedule.at(period), period)  # compiles outside the clock
    twin, watch, stopped = Twin(scene), Watch(), ""
    began = time.perf_counter()
    try:
        for k in range(1, max(1, round(schedule.duration / period)) + 1):
            watch.see(twin.advance(schedule.at(k * period), period))
    except RunError as error:
        stopped = str(error)
    seconds = time.perf_counter() - began
    allowed, travel = deepest_allowed(twin, watch.speed), 0.5 * twin.step_size * watch.speed
    return Result(
        case.name, case.why, case.form, twin.elements, twin.step_size, twin.time, watch.steps, watch.cut_steps,
        watch.iterations, watch.interventions, watch.depth, allowed, travel, watch.speed, twin.time / seconds,
        watch.energy, judge(case, watch, stopped, allowed + travel),
    )  # fmt: skip


def judge(case: HardCase, watch: Watch, stopped: str, allowed: float) -> str:
    """`ok`, or what is wrong with a run."""
    must_say = STOPS.get(case.scene_name)
    if stopped and must_say and must_say in stopped:
        return f"ok, stopped: {stopped}"
    if stopped:
        return f"stopped: {stopped}"
    if must_say:
        return f'expected it to stop and say "{must_say}", found it followed to the end'
    if not watch.finite:
        return "a state that is no number"
    if watch.gained:
        return f"{watch.gained} gave the string energy, where it can only take it"
    if watch.energy is not None and watch.energy > UNACCOUNTED:
        return f"{watch.energy:.0%} of the energy is not accounted for"
    if watch.depth > allowed:
        return f"{watch.depth * 1e3:.3g} mm into the wall, where {allowed * 1e3:.3g} mm can be explained"
    return "ok"
