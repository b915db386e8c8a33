# SPDX-License-Identifier: Apache-2.0
"""Whirl states against the simulation in time, over a grid of load and speed.

Each point is run from the axis, with bow and eccentricity, and the motion of the last third is compared with the
steady states found for it, and with their modulation by bow and eccentricity. A run is made longer where a stable state
is slow to settle on. Where a run whirls steadily as no state found does, Newton's method starts from its last shape;
where it whirls with two frequencies, harmonic balance starts from its Fourier amplitudes. On each stable state that the
run from the axis is not on, another run begins: if it stays there, state and motion coexist. Points are appended to a
file, and a study that was broken off goes on where it stopped.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

from drill_twin.api.ensemble import Ensemble
from drill_twin.api.rotordynamics import steady_scene
from drill_twin.core.arrays import ComplexArray
from drill_twin.dynamics.rotordynamics.campbell import growth_map
from drill_twin.dynamics.rotordynamics.equations import EquationsOfMotion
from drill_twin.dynamics.rotordynamics.steady.steady_whirl import SteadyWhirl, TurningEquations
from drill_twin.dynamics.rotordynamics.steady.whirl_state import WhirlState
from drill_twin.dynamics.rotordynamics.steady.whirl_states import state_near, whirl_states
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.scene import Scene
from drill_twin.scene.blocks.numerics import frame_period
from drill_twin.scene.blocks.string import Mark
from drill_twin.scene.load import override
from drill_twin.scene.set_points.command import Command
from drill_twin_evidence.whirl_compare import two_frequency_stability as two_frequency
from drill_twin_evidence.whirl_compare.harmonic_balance import TwoFrequencyEquations, from_amplitudes
from drill_twin_evidence.whirl_compare.motion import STEADY, TWO, Motion, motion_of
from drill_twin_evidence.whirl_compare.points import (
    MISSED,
    ON_A_STATE,
    TWO_COMPUTED,
    Point,
    TwoFrequencies,
    points_file,
    setup_of,
)
from drill_twin_evidence.whirl_compare.two_frequency_stability import TwoFrequencyState
from drill_twin_evidence.whirl_compare.verdicts import is_on, judge, near, places

RATE = 100.0
"""Samples of the marks a second, at most."""
LAST = 1.0 / 3.0
"""Share of a run, at its end, that is compared."""
RESOLVED = 0.4
"""Highest harmonic of a first guess over the sampling rate."""
SETTLING, LONGER = 8.0, 6.0
"""Decay times of a stable state that a run is given to settle on it, and longest run over the duration asked for."""


def compare(
    scene: Scene,
    weights: Sequence[float],
    speeds: Sequence[float],
    *,
    duration: float,
    record: Path | None = None,
    workers: int | None = None,
    progress: Callable[[int], None] = lambda _: None,
) -> list[Point]:
    """Compare on a grid.

    Args:
        scene: Scene with a wall in a straight vertical hole.
        weights: Weight on bit [N].
        speeds: Rotation [rad/s].
        duration: Simulated time of each run [s].
        record: File of the points (JSON lines), continued if it exists.
        workers: Threads of the ensemble.
        progress: Called with the number of points done.

    Raises:
        ArgumentError: The file holds points of another study.
        SceneError: No steady whirl can exist in the scene.
    """
    equations = EquationsOfMotion(steady_scene(scene, None, ()))
    own = with_marks(equations)
    file = None if record is None else points_file(record, setup_of(own, duration))
    done = {} if file is None else {(point.weight_on_bit, point.rotation): point for point in file.results}
    for weight in weights:
        missing = [speed for speed in speeds if (weight, speed) not in done]
        for point in _row(own, equations, weight, missing, duration, workers):
            done[weight, point.rotation] = point
            if file is not None:
                file.add(point)
            progress(len(done))
    return [done[weight, speed] for weight in weights for speed in speeds]


def with_marks(equations: EquationsOfMotion) -> Scene:
    """The scene with marks on the centre line at the nodes."""
    scene = equations.scene
    marks = tuple(
        Mark(name=f"m{k}", distance_from_bit=float(place), on="centre") for k, place in enumerate(places(equations))
    )
    return scene.model_copy(update={"string": scene.string.model_copy(update={"marks": marks})})


class _Run:
    """End of a run in time: its path at the marks, shape (T, m), and what kind of motion that is."""

    def __init__(self, path: ComplexArray, period: float, clearance: float) -> None:
        self.path, self.period = path[int(len(path) * (1.0 - LAST)) :], period
        self.motion: Motion = motion_of(self.path, period, clearance)


def _row(
    scene: Scene, equations: EquationsOfMotion, weight: float, speeds: list[float], duration: float, workers: int | None
) -> Iterator[Point]:
    """Points of one load."""
    if not speeds:
        return
    for speed, first in zip(speeds, _runs(scene, weight, speeds, duration, workers), strict=True):
        command = Command(weight, speed)
        states = whirl_states(equations, command)
        axis = float(growth_map(equations, np.array([weight]), np.array([speed])).lateral[0, 0])
        point = _explained(equations, states, axis, command, first, duration)
        settling = max((-SETTLING / state.growth for state in states if state.growth < 0.0), default=0.0)
        if not point.agrees and states and settling > duration * (1.0 - LAST):
            longer = min(max(2.0 * duration, settling / (1.0 - LAST)), LONGER * duration)
            (again,) = _runs(scene, weight, [speed], longer, workers)
            point = _explained(equations, states, axis, command, again, longer)
        own = point.ratio if point.verdict in ON_A_STATE else np.inf
        others = [state for state in states if state.is_stable and not near(own, (state.ratio,))]
        held = tuple((state.ratio, _stays(scene, state, duration)) for state in others)
        yield replace(point, held=held)


def _explained(
    equations: EquationsOfMotion, states: Sequence[WhirlState], axis: float, command: Command, run: _Run, time: float
) -> Point:
    """Verdict on a run; where the search has no such state, with the one that Newton's method finds from the run."""
    point = replace(judge(equations, states, axis, command, run.motion), duration=time)
    if point.verdict == MISSED and run.motion.kind == STEADY:
        found = _steady_state(equations, command, run)
        if found is not None and near(point.ratio, (found.ratio,)):
            wider = judge(equations, (*states, found), axis, command, run.motion)
            return replace(wider, duration=time, searched=False)
    if point.verdict == MISSED and run.motion.kind == TWO:
        two = _two_frequency_state(equations, command, run)
        if two is not None and two.is_stable and is_on(equations, two.whirl, run.motion):
            ratios = two.whirl.omega / command.rotation, two.whirl.second / command.rotation
            return replace(point, verdict=TWO_COMPUTED, two=TwoFrequencies(*ratios, two.growth, two.neutral))
    return point


def _steady_state(equations: EquationsOfMotion, command: Command, run: _Run) -> WhirlState | None:
    """Steady whirl near the last shape of a run."""
    u, _ = equations.on_axis(command)
    place, slope = _line(equations, run.path[-1:])
    moved = u.copy()
    moved[:, 0], moved[:, 1], moved[:, 3], moved[:, 4] = place[0].real, place[0].imag, slope[0].real, slope[0].imag
    u = u + equations.rows((moved - u)[:, equations.columns][equations.free])
    return state_near(equations, SteadyWhirl(command, u, run.motion.speed))


def _two_frequency_state(equations: EquationsOfMotion, command: Command, run: _Run) -> TwoFrequencyState | None:
    """Whirl with two frequencies near the end of a run."""
    omega, sigma = run.motion.speed, run.motion.second - run.motion.speed
    harmonics = max(1, math.floor(RESOLVED * math.tau / (run.period * abs(sigma))))
    times, order = run.period * np.arange(len(run.path)), np.arange(-harmonics, harmonics + 1)
    turns = np.exp(1j * np.outer(times, omega + order * sigma))
    amplitudes = np.asarray(np.linalg.lstsq(turns, run.path, rcond=None)[0], np.complex128)
    guess = from_amplitudes(equations, command, *_line(equations, amplitudes), omega, sigma)
    return two_frequency.state_near(TwoFrequencyEquations(TurningEquations(equations)), guess)


def _line(equations: EquationsOfMotion, values: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
    """Values at the marks, shape (k, m), at all nodes, and their slopes; no slope at an end that does not tilt."""
    arc = equations.model.rod.arc
    ends = tuple("clamped" if equations.constrained[end, 3] else "not-a-knot" for end in range(2))
    zero = np.zeros((len(values), 1))
    lines = [
        CubicSpline(np.append(places(equations), arc[-1]), np.hstack([part, zero]), axis=1, bc_type=ends)
        for part in (values.real, values.imag)
    ]
    place, slope = (lines[0](arc, order) + 1j * lines[1](arc, order) for order in (0, 1))
    return place, slope


def _runs(scene: Scene, weight: float, speeds: list[float], duration: float, workers: int | None) -> list[_Run]:
    """Runs from the axis."""
    rate = min(RATE, scene.numerics.frame_rate)
    vary: dict[str, list[float | str]] = {"rig.weight_on_bit.value": [weight] * len(speeds),
                                          "rig.rotation.value": list(speeds)}  # fmt: skip
    ensemble = Ensemble(scene, vary, zipped=True, overrides={"rig.start": "axis"})
    found = ensemble.run(duration, outputs=("marks",), mark_rate=rate, workers=workers)
    centre: Any = found["centre"][..., 0] + 1j * found["centre"][..., 1]
    return [_Run(line, 1.0 / rate, scene.least_clearance) for line in centre]


def _stays(scene: Scene, state: WhirlState, duration: float) -> bool:
    """True if a run that begins on a stable state, with bow and eccentricity, is there at its end."""
    command, period = state.whirl.command, frame_period(min(RATE, scene.numerics.frame_rate))
    own = {"rig.weight_on_bit.value": command.weight_on_bit, "rig.rotation.value": command.rotation}
    twin = Twin(override(scene, own))
    u, v, _ = state.whirl.motion
    twin.dynamics.begin(u, v, command)
    path = np.array([twin.advance(command, period).marks.centre[:, :2] for _ in range(round(duration / period))])
    motion = _Run(path[..., 0] + 1j * path[..., 1], period, scene.least_clearance).motion
    return motion.kind == STEADY and near(motion.speed / command.rotation, (state.ratio,))
