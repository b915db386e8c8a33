# SPDX-License-Identifier: Apache-2.0
"""Whirl states against the simulation in time, over a grid of load and speed.

Each point is run from the axis, with bow and eccentricity, and the motion of the last third is compared with the
steady states found for it, and with their modulation by bow and eccentricity. A run is made longer where a stable state
is slow to settle on. Where a stable state exists and the run is elsewhere all the same, a second run begins on the
state: if it stays there, state and motion coexist. Where a run whirls steadily as no state found does, Newton's method
starts from its last shape. Points are appended to a file, and a study that was broken off goes on where it stopped.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

from drill_twin.api.ensemble import Ensemble
from drill_twin.api.rotordynamics import steady_scene
from drill_twin.base.arrays import Array, ComplexArray
from drill_twin.errors import ArgumentError
from drill_twin.rotordynamics.equations import EquationsOfMotion
from drill_twin.rotordynamics.growth_map import growth_map
from drill_twin.rotordynamics.imperfections import modulation
from drill_twin.rotordynamics.steady_whirl import TurningEquations, Whirl
from drill_twin.rotordynamics.whirl_states import WhirlState, state_near, whirl_states
from drill_twin.scene import Scene
from drill_twin.scene.blocks.string import Mark
from drill_twin.schedule.command import Command
from drill_twin.studies.rotordynamics.motion import AXIS, STEADY, TWO, Motion, motion_of

MARKS = 11
"""Marks along the string, ends left out."""
RATE = 100.0
"""Samples of the marks a second, at most."""
LAST = 1.0 / 3.0
"""Share of a run, at its end, that is compared."""
SAME_SPEED, SAME_RATIO = 0.02, 1e-3
"""Whirl speeds agree within this share, or within this share of the rotation."""
MODULATION, SAME_BEAT = 0.3, 0.1
"""Largest change of the shape, over the clearance, of a whirl with a modulation, and difference of the frequency of a
modulation from that of the rotation or of the state's oscillation in the frame of the whirl, as a share."""
BEATS = 10
"""Periods of a modulation over which it is measured."""
SETTLING, LONGEST = 8.0, 6.0
"""Decay times of a stable state that a run is given to settle on it, and longest run over the duration asked for."""
ON_STATE, MODULATED, PAST_HOPF, NO_STATE, COEXISTS, MISSED = (
    "a stable state", "a stable state, modulated", "modulated, about an unstable state", "no stable state",
    "beside a stable state", "no such state found",
)  # fmt: skip
AGREES = (ON_STATE, MODULATED, PAST_HOPF, NO_STATE)
"""Verdicts of points where tool and simulation agree."""
FORMAT = 2
"""Of the records."""


@dataclass(frozen=True)
class Point:
    """One load and speed."""

    weight_on_bit: float
    """[N]."""
    rotation: float
    """[rad/s]."""
    motion: str
    """Kind of the simulated motion."""
    ratio: float
    """Its whirl speed over the rotation."""
    second: float | None
    """Second speed of a motion of two frequencies, over the rotation."""
    change: float | None
    """Change of its shape in the frame of the whirl, over the clearance."""
    states: tuple[tuple[float, float, float], ...]
    """Ratio, growth [1/s] and frequency in its frame [Hz] of each state found; of the axis with the ratio 0."""
    stable: tuple[float, ...]
    """Ratios of the stable ones on the wall."""
    verdict: str
    modulation: float | None = None
    """Change of the shape by bow and eccentricity, to first order, of the stable state that the motion is on."""
    duration: float = 0.0
    """Simulated time of the run [s]; longer than asked for where a state is slow to settle on."""
    searched: bool = True
    """False if the state that the motion is on was not found by the search, but from the run's shape."""
    held: bool | None = None
    """Of a run that begins on the stable state: whether it stays there; None if none was made."""

    @property
    def agrees(self) -> bool:
        """True if the simulated motion is what the states say."""
        return self.verdict in AGREES

    @property
    def reason(self) -> str:
        """Reason of a verdict, as far as it was tested."""
        if self.verdict == COEXISTS:
            tested = "another basin: a run begun on the state stays"
            return {True: tested, False: "a run begun on the state leaves it", None: ""}[self.held]
        if not self.searched:
            return "missed by the search; found from the shape of the run"
        return ""


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
    own = with_marks(steady_scene(scene, None, ()))
    done = dict(_recorded(record, _head(own, duration)))
    equations = EquationsOfMotion(own)
    for weight in weights:
        missing = [speed for speed in speeds if (weight, speed) not in done]
        for point in _row(own, equations, weight, missing, duration, workers):
            done[weight, point.rotation] = point
            if record is not None:
                with record.open("a", encoding="utf-8") as file:
                    file.write(json.dumps(asdict(point)) + "\n")
        progress(len(done))
    return [done[weight, speed] for weight in weights for speed in speeds]


def with_marks(scene: Scene) -> Scene:
    """The scene with marks on the centre line, evenly along the string."""
    length = scene.string.length
    marks = tuple(
        Mark(name=f"m{k + 1}", distance_from_bit=length * (k + 1) / (MARKS + 1), on="centre") for k in range(MARKS)
    )
    return scene.model_copy(update={"string": scene.string.model_copy(update={"marks": marks})})


def _head(scene: Scene, duration: float) -> str:
    """First line of a record: what the points are of."""
    data = scene.model_dump(mode="json", exclude_none=True)
    return json.dumps({"scene": data, "duration": duration, "format": FORMAT}, sort_keys=True)


def _recorded(record: Path | None, head: str) -> Iterator[tuple[tuple[float, float], Point]]:
    if record is None:
        return
    if not record.exists():
        record.write_text(head + "\n", encoding="utf-8")
        return
    first, *lines = record.read_text(encoding="utf-8").splitlines()
    if first != head:
        raise ArgumentError(f"{record}: expected points of this scene and duration, found others; take another file")
    for line in lines:
        data = json.loads(line)
        data["states"], data["stable"] = tuple(tuple(one) for one in data["states"]), tuple(data["stable"])
        yield (data["weight_on_bit"], data["rotation"]), Point(**data)


def _row(
    scene: Scene, equations: EquationsOfMotion, weight: float, speeds: list[float], duration: float, workers: int | None
) -> Iterator[Point]:
    """Points of one load."""
    if not speeds:
        return
    motions = _motions(scene, weight, speeds, duration, workers, start="axis")
    for speed, run in zip(speeds, motions, strict=True):
        command, (motion, shape) = Command(weight, speed), run
        states = whirl_states(equations, command)
        axis = float(growth_map(equations, np.array([weight]), np.array([speed])).lateral[0, 0])
        point = replace(judge(equations, states, axis, command, motion), duration=duration)
        settling = max((-SETTLING / state.growth for state in states if state.growth < 0.0), default=0.0)
        if point.verdict == COEXISTS and settling > duration * (1.0 - LAST):
            longer = min(max(2.0 * duration, settling / (1.0 - LAST)), LONGEST * duration)
            motion, shape = _motions(scene, weight, [speed], longer, workers, start="axis")[0]
            point = replace(judge(equations, states, axis, command, motion), duration=longer)
        if point.verdict == MISSED and motion.kind == STEADY:
            point = _from_run(equations, states, axis, command, motion, shape, point)
        if point.verdict == COEXISTS:
            again, _ = _motions(scene, weight, [speed], duration, workers, start="whirl-state")[0]
            point = replace(point, held=again.kind == STEADY and _near(again.speed / speed, point.stable))
        yield point


def _from_run(
    equations: EquationsOfMotion, states: Sequence[WhirlState], axis: float, command: Command, motion: Motion,
    shape: ComplexArray, point: Point,
) -> Point:  # fmt: skip
    """The point with the state that Newton's method finds from the last shape of a run, if it is the run's."""
    arc = equations.model.rod.arc
    line = CubicSpline(np.append(_places(equations), arc[-1]), np.append(shape, 0.0))
    u, _ = equations.on_axis(command)
    place, slope = line(arc), line(arc, 1)
    moved = u.copy()
    moved[:, 0], moved[:, 1], moved[:, 3], moved[:, 4] = place.real, place.imag, slope.real, slope.imag
    u = u + equations.rows((moved - u)[:, equations.columns][equations.free])
    found = state_near(equations, Whirl(command, u, motion.speed))
    if found is None or not _near(motion.speed / command.rotation, (found.ratio,)):
        return point
    return replace(judge(equations, (*states, found), axis, command, motion), duration=point.duration, searched=False)


def _motions(
    scene: Scene, weight: float, speeds: list[float], duration: float, workers: int | None, start: str
) -> list[tuple[Motion, ComplexArray]]:
    """Motions of runs, and their last shapes at the marks."""
    rate = min(RATE, scene.numerics.frame_rate)
    vary: dict[str, list[float | str]] = {"rig.weight_on_bit.value": [weight] * len(speeds),
                                          "rig.rotation.value": list(speeds)}  # fmt: skip
    ensemble = Ensemble(scene, vary, zipped=True, overrides={"rig.start": start})
    found = ensemble.run(duration, outputs=("marks",), mark_rate=rate, workers=workers)
    centre: Any = found["centre"][..., 0] + 1j * found["centre"][..., 1]
    first = int(centre.shape[1] * (1.0 - LAST))
    return [(motion_of(line[first:], 1.0 / rate, scene.least_clearance), line[-1]) for line in centre]


def judge(
    equations: EquationsOfMotion, states: Sequence[WhirlState], axis: float, command: Command, motion: Motion
) -> Point:
    """Verdict on a motion, given the states and the growth on the axis [1/s]."""
    rotation = command.rotation
    stable = tuple(state.ratio for state in states if state.is_stable)
    own = next((one for one in states if one.is_stable and _near(motion.speed / rotation, (one.ratio,))), None)
    change = _predicted(equations, own) if own is not None else None
    if motion.kind == AXIS:
        verdict = ON_STATE if axis < 0.0 else MISSED
    elif motion.kind == STEADY and own is not None:
        verdict = ON_STATE
    elif motion.kind == TWO and own is not None and _beats(motion, rotation - motion.speed):
        verdict = MODULATED
    elif motion.kind in {STEADY, TWO} and any(_about(equations, one, motion) for one in states if not one.is_stable):
        verdict = PAST_HOPF
    elif motion.kind == STEADY:
        verdict = MISSED
    else:
        verdict = COEXISTS if stable or axis < 0.0 else NO_STATE
    second, simulated = (None if math.isnan(x) else x for x in (motion.second / rotation, motion.change))
    found = ((0.0, axis, 0.0), *((one.ratio, one.growth, one.growth_frequency) for one in states))
    ratio = motion.speed / rotation
    return Point(command.weight_on_bit, rotation, motion.kind, ratio, second, simulated, found, stable, verdict, change)


def _predicted(equations: EquationsOfMotion, state: WhirlState) -> float:
    """Change of the shape of a state by bow and eccentricity, to first order, measured as that of a run."""
    found = modulation(TurningEquations(equations), state.whirl)
    beats = math.tau * BEATS / max(abs(found.rate), 1e-3)
    times = np.linspace(0.0, beats, 40 * BEATS)
    arc, places = equations.model.rod.arc, _places(equations)
    line = np.array([np.interp(places, arc, one) for one in found.line(times)])
    return motion_of(line, float(times[1]), equations.scene.least_clearance).change


def _places(equations: EquationsOfMotion) -> Array:
    """Distances of the marks from the bit [m]."""
    return np.asarray(equations.model.rod.arc[-1] * (np.arange(MARKS) + 1.0) / (MARKS + 1.0))


def _near(ratio: float, others: Sequence[float]) -> bool:
    return any(abs(ratio - other) < max(SAME_SPEED * abs(other), SAME_RATIO) for other in others)


def _beats(motion: Motion, rate: float) -> bool:
    """True if a motion of two frequencies is a modulation at a rate [rad/s] in the frame of its whirl."""
    return abs(abs(motion.second - motion.speed) / max(abs(rate), 1e-9) - 1.0) < SAME_BEAT


def _about(equations: EquationsOfMotion, state: WhirlState, motion: Motion) -> bool:
    """True if a motion has speed and radii of an unstable state, and is modulated as that is left, or hardly at all."""
    radius = (
        np.interp(_places(equations), equations.model.rod.arc, state.whirl.radius) / equations.scene.least_clearance
    )
    near = _near(motion.speed / state.whirl.command.rotation, (state.ratio,))
    like = near and float(np.abs(radius - motion.radius).max()) < MODULATION and motion.change < MODULATION
    return like and (motion.kind == STEADY or _beats(motion, math.tau * state.growth_frequency))
