# SPDX-License-Identifier: Apache-2.0
"""Runs of hard cases, and their assessment."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from drill_twin.ensemble.outputs import Collector, Request, Variable
from drill_twin.ensemble.run import frames_of, run_scene
from drill_twin.errors import DrillTwinError
from drill_twin.runner import compile_kernel
from drill_twin.studies.pool import run_jobs
from drill_twin.studies.stress.bound import allowed_depth
from drill_twin.studies.stress.case import EXPECTED_STOPS, HardCase
from drill_twin.twin.frame import Frames
from drill_twin.twin.twin import Twin

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
    elements: int = 0
    step: float = 0.0
    """Nominal time step [s]."""
    reached: float = 0.0
    """Simulated time reached [s]."""
    steps: int = 0
    cut_steps: int = 0
    iterations: int = 0
    interventions: int = 0
    """Frames that the step guard rejected and repeated."""
    depth: float = -np.inf
    """Largest penetration of the wall [m]; negative: no contact."""
    allowed: float = 0.0
    """Penetration that the contact law allows at the speeds of the run [m]."""
    travel: float = 0.0
    """Displacement in half a step at the largest speed [m]: contact is evaluated once a step."""
    speed: float = 0.0
    """Largest lateral speed of a node [m/s]."""
    real_time_factor: float = 0.0
    """Simulated time over wall-clock time, output of frames included."""
    energy: float | None = None
    """Largest energy error, over the largest energy in motion; None without the audit."""
    verdict: str = ""
    """`ok`, or the reason why the run is not valid."""

    @property
    def ok(self) -> bool:
        """True if the case is in order: run to its end, or stopped for the expected reason."""
        return self.verdict.startswith("ok")

    def to_dict(self) -> dict[str, Any]:
        """Plain types for JSON (`drill_twin.studies.json_io`)."""
        return asdict(self) | {"ok": self.ok}


class RunStatistics:
    """Statistics over the frames of a run.

    Attributes:
        depth: Largest penetration of the wall [m].
        speed: Largest lateral speed of a node [m/s].
        finite: Whether all numbers were finite.
        energy: Largest energy error, over the energy in motion; None without the audit.
        gained: Name of a dissipative effect that added energy.
    """

    def __init__(self) -> None:
        self.steps = self.cut_steps = self.iterations = self.interventions = 0
        self.depth, self.speed, self.finite = -np.inf, 0.0, True
        self.energy: float | None = None
        self.gained = ""

    def add(self, frames: Frames) -> None:
        """Add frames; with an energy audit one at a time, since it tells of the last alone."""
        self.steps += frames.stats.steps
        self.cut_steps += frames.stats.cut_steps
        self.iterations += frames.stats.iterations
        self.interventions += len(frames.interventions)
        self.depth = max(self.depth, float(frames.wall_depth.max()))
        if frames.v is not None:
            self.speed = max(self.speed, float(np.linalg.norm(frames.v[..., :2], axis=-1).max()))
        parts = (frames.u, frames.v, frames.tangents, frames.wall_force)
        self.finite = self.finite and all(bool(np.isfinite(part).all()) for part in parts if part is not None)
        if frames.energy is not None:
            self.energy = max(self.energy or 0.0, abs(frames.energy.share))
            least = -ROUNDING * frames.energy.scale
            self.gained = self.gained or next((k for k, heat in frames.energy.dissipated.items() if heat < least), "")


class Statistics(Collector):
    """`RunStatistics` of a member, with its twin."""

    whole = True

    def __init__(self, twin: Twin, request: Request) -> None:
        super().__init__(twin, request)
        self.found = RunStatistics()

    def add_frames(self, frames: Frames) -> None:
        """Add frames; with an energy audit one at a time."""
        self.found.add(frames)

    def close(self) -> Mapping[str, Variable]:
        """The statistics and the twin."""
        return {"statistics": Variable(self.found, (), ""), "twin": Variable(self.twin, (), "")}


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
    """Run a case as a member, with the energy audit if `energy`; one that fails is a result and raises no error."""
    try:
        scene = case.scene(energy=energy)
        compile_kernel(scene, 1.0 / scene.numerics.frame_rate)  # before the timing starts
        began = time.perf_counter()
        run = run_scene(scene, [Statistics], *frames_of(scene), size=1 if energy else None)
        seconds = time.perf_counter() - began
    except DrillTwinError as error:
        return Result(case.name, case.why, case.form, verdict=f"stopped: {error}")
    if not run.values:
        return Result(case.name, case.why, case.form, verdict=f"stopped: {run.failure}")
    found: RunStatistics = run.values["statistics"].value
    twin: Twin = run.values["twin"].value
    allowed, travel = allowed_depth(twin, found.speed), 0.5 * twin.step_size * found.speed
    return Result(
        case.name, case.why, case.form, twin.elements, twin.step_size, twin.time, found.steps, found.cut_steps,
        found.iterations, found.interventions, found.depth, allowed, travel, found.speed, twin.time / seconds,
        found.energy, verdict_on(case, found, run.failure, allowed + travel),
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
