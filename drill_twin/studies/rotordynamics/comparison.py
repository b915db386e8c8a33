# SPDX-License-Identifier: Apache-2.0
"""Whirl states against the simulation in time, over a grid of load and speed.

Each point is run from the axis, with bow and eccentricity, and the motion of the last third is compared with the steady
states found for it. Where a stable state exists and the run is elsewhere, a second run begins on the state: if it stays
there, state and motion coexist. Points are appended to a file, and a study that was broken off goes on where it
stopped.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from drill_twin.api.ensemble import Ensemble
from drill_twin.api.rotordynamics import steady_scene
from drill_twin.errors import ArgumentError
from drill_twin.rotordynamics.equations import EquationsOfMotion
from drill_twin.rotordynamics.growth_map import growth_map
from drill_twin.rotordynamics.whirl_states import WhirlState, whirl_states
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
MODULATION = 0.3
"""Largest change of the shape, over the clearance, of a whirl with a modulation."""
ON_STATE, ABOUT_STATE, NO_STATE, COEXISTS, MISSED = (
    "a stable state", "about a state", "no stable state", "beside a stable state", "no such state found",
)  # fmt: skip
AGREES = (ON_STATE, ABOUT_STATE, NO_STATE)
"""Verdicts of points where tool and simulation agree."""


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
    states: tuple[tuple[float, float], ...]
    """Ratio and growth [1/s] of each state found; of the string on the axis with the ratio 0."""
    stable: tuple[float, ...]
    """Ratios of the stable ones on the wall."""
    verdict: str
    held: bool | None = None
    """Of a run that begins on the stable state: whether it stays there; None if none was made."""

    @property
    def agrees(self) -> bool:
        """True if the simulated motion is what the states say."""
        return self.verdict in AGREES


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
    return json.dumps({"scene": scene.model_dump(mode="json", exclude_none=True), "duration": duration}, sort_keys=True)


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
    for speed, motion in zip(speeds, motions, strict=True):
        states = whirl_states(equations, Command(weight, speed))
        axis = float(growth_map(equations, np.array([weight]), np.array([speed])).lateral[0, 0])
        point = judge(equations, states, axis, Command(weight, speed), motion)
        if point.verdict == COEXISTS:
            again = _motions(scene, weight, [speed], duration, workers, start="whirl-state")[0]
            held = again.kind == STEADY and _near(again.speed / speed, point.stable)
            point = Point(**{**asdict(point), "held": held})
        yield point


def _motions(
    scene: Scene, weight: float, speeds: list[float], duration: float, workers: int | None, start: str
) -> list[Motion]:
    rate = min(RATE, scene.numerics.frame_rate)
    vary: dict[str, list[float | str]] = {"rig.weight_on_bit.value": [weight] * len(speeds),
                                          "rig.rotation.value": list(speeds)}  # fmt: skip
    ensemble = Ensemble(scene, vary, zipped=True, overrides={"rig.start": start})
    found = ensemble.run(duration, outputs=("marks",), mark_rate=rate, workers=workers)
    centre: Any = found["centre"][..., 0] + 1j * found["centre"][..., 1]
    first = int(centre.shape[1] * (1.0 - LAST))
    return [motion_of(line[first:], 1.0 / rate, scene.least_clearance) for line in centre]


def judge(
    equations: EquationsOfMotion, states: Sequence[WhirlState], axis: float, command: Command, motion: Motion
) -> Point:
    """Verdict on a motion, given the states and the growth on the axis [1/s]."""
    stable = tuple(state.ratio for state in states if state.is_stable)
    ratio = motion.speed / command.rotation
    if motion.kind == AXIS:
        verdict = ON_STATE if axis < 0.0 else MISSED
    elif motion.kind == STEADY and _near(ratio, stable):
        verdict = ON_STATE
    elif motion.kind in {STEADY, TWO} and motion.change < MODULATION and _about(equations, states, motion):
        verdict = ABOUT_STATE
    elif motion.kind == STEADY:
        verdict = MISSED
    else:
        verdict = COEXISTS if stable or axis < 0.0 else NO_STATE
    second, change = (None if math.isnan(x) else x for x in (motion.second / command.rotation, motion.change))
    found = ((0.0, axis), *((state.ratio, state.growth) for state in states))
    return Point(command.weight_on_bit, command.rotation, motion.kind, ratio, second, change, found, stable, verdict)


def _near(ratio: float, others: Sequence[float]) -> bool:
    return any(abs(ratio - other) < max(SAME_SPEED * abs(other), SAME_RATIO) for other in others)


def _about(equations: EquationsOfMotion, states: Sequence[WhirlState], motion: Motion) -> bool:
    """True if a motion has speed and radii of a state, stable or not, but for its modulation."""
    arc = equations.model.rod.arc
    places = arc[-1] * (np.arange(MARKS) + 1.0) / (MARKS + 1.0)
    for state in states:
        radius = np.interp(places, arc, state.whirl.radius) / equations.scene.least_clearance
        near = _near(motion.speed / state.whirl.command.rotation, (state.ratio,))
        if near and float(np.abs(radius - motion.radius).max()) < MODULATION:
            return True
    return False
