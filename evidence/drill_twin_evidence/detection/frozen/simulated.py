# SPDX-License-Identifier: Apache-2.0
"""The frozen simulated runs, and what is true of them, from the full state and the linear modes.

**Parts.** The motion of each node, on even steps of the rotation, less the part that turns with the node's spin: the
mean under a Hann window of `HALF` revolutions before and after. In an inclined hole the place where the string lies is
taken off too, the mean over the whole run since the rotation is steady.

**Amplitude.** The mean size of the rest over `SMOOTH` revolutions; of its logarithm, up to its largest value, the
nearest function that never falls (isotonic regression). So an orbit that comes and goes counts as none until it stays.

**Whirl.** In a vertical hole: the amplitude reaches `LARGE`. In an inclined one it must go round: nine tenths of its
power turn in one sense. No whirl: no linear mode grows, and the amplitude stays under `SMALL` or, in an inclined hole,
at most two thirds turn in one sense, or the string on the low side does not turn by a quarter of a turn in the run.
Other runs are not scored.

**Onset.** Not dated where the amplitude exceeds `SMALL` in the first revolution, as a string does that falls to the low
side while it begins to whirl: there it counts only that an onset is found.

**States.** In windows of `WINDOW` revolutions about each time, where they are clear (`CLEAR`); else none is true.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from scipy.ndimage import uniform_filter1d
from scipy.optimize import isotonic_regression
from scipy.signal import fftconvolve

from drill_twin.api.rotordynamics import modes
from drill_twin.core.arrays import Array, ComplexArray, Mask
from drill_twin.core.errors import DrillTwinError
from drill_twin.core.files.kept_files import cache_folder
from drill_twin.scene import config_dir, parse_scene
from drill_twin.whirl import MarkInfo
from drill_twin_evidence.detection import runs
from drill_twin_evidence.detection.cases import random_overrides
from drill_twin_evidence.detection.frozen.measured import Errors, Turning, measured
from drill_twin_evidence.detection.frozen.truth import (
    BACKWARD,
    BENDING,
    CREEP,
    FIXED,
    FORWARD,
    IMPACTS,
    IRREGULAR,
    PER_TURN,
    ROLLING,
    SPIRAL,
    FrozenRecord,
    Truth,
)  # fmt: skip
from drill_twin_evidence.detection.scene import BENCH_SCENE

FIRST = 4_600_000
"""First seed of the drawn runs; nothing was tuned on it or on those after it."""
DRAWN = 40
STEPS, HALF, SMOOTH, WINDOW = 16, 12.0, 1.5, 3.0
"""Steps in a revolution; half the window of the part that turns with the string, smoothing of the amplitude, half the
window of a state [rev]."""
LARGE, SMALL = 0.15, 0.02
"""Amplitude over the clearance of a whirl, and below which there is none; between, the run is not scored."""
SLOW, STRIKES, BROKEN = 0.05, 0.7, 0.5
"""Whirl ratio without a sense; impacts in a turn; coherence of the angle below which a motion is irregular."""
CLEAR: dict[str, tuple[float, float]] = {
    "regular": (0.93, 0.2), "touching": (0.9, 0.1), "slip": (0.25, 0.7),
    "plane": (0.9, 0.5), "lobe": (0.5, 0.15),
}  # fmt: skip
"""Regular: coherence of the angle above, unevenness of the radius below; Touching:
share of the time above, or free below. Slip over the rim speed: rolling below, creep above. Planarity: a plane above, a
helix below. Second lobe over the first: bending above, none below."""

WELLS: tuple[tuple[str, dict[str, str]], ...] = tuple(
    (name, {"rpm": f"{rpm}", "rig.duration": "40 s"})
    for name, speeds in (("s_shaped", (60, 120, 180)), ("extended_reach", (80, 140)), ("vertical_3000", (60, 120, 180)))
    for rpm in speeds
)
"""Installed full-size wells, from the start of the rotation on."""
SLOPES: tuple[tuple[float, float], ...] = tuple((angle, drag) for angle in (2, 8, 30) for drag in (0.3, -1.0, -3.0))
"""The bench in a hole of an inclination [deg], with a drag [N s/m^2] that damps or, negative, makes it grow."""


def simulated_records(share: int = 1) -> Iterator[FrozenRecord]:
    """The frozen runs as camera and rig measure them, kept in the cache once made."""
    for number, (name, scene, overrides, drag) in enumerate(list(_plans())[::share]):
        found = _made(name, scene, overrides, drag)
        if found is not None:
            yield _record(number, name, found)


def _plans() -> Iterator[tuple[str, str, dict[str, str], float | None]]:
    for seed in range(FIRST, FIRST + DRAWN):
        overrides = random_overrides(seed)
        yield f"drawn {seed}", BENCH_SCENE, overrides, None
    for angle, drag in SLOPES:
        draw = np.random.default_rng([FIRST, int(angle), round(100 * drag) % 1000])
        changes = {
            "hole.inclination": f"{angle} deg", "rig.rotation.value": f"{draw.uniform(1.5, 5.0):.3f} rev/s",
            "wob": f"{draw.uniform(2.0, 12.0):.2f} N", "rig.duration": "40 s",
            "effects.wall_friction.coefficient": f"{draw.uniform(0.05, 0.3):.3f}",
        }  # fmt: skip
        yield f"bench at {angle} deg, drag {drag}", BENCH_SCENE, changes, drag
    for name, changes in WELLS:
        text = (config_dir() / "wells" / f"{name}.yaml").read_text()
        yield f"{name} at {changes['rpm']} rpm", text, changes, None


def _made(name: str, scene: str, overrides: dict[str, str], drag: float | None) -> dict[str, Any] | None:
    """Signals and truth of a run, from the cache where they are; None where the run could not be followed."""
    key = hashlib.sha256(json.dumps([name, scene, overrides, drag, Path(__file__).read_text()]).encode()).hexdigest()[
        :20
    ]
    path = cache_folder() / f"frozen_run_{key}.npz"
    if path.is_file():
        with np.load(path, allow_pickle=False) as kept:
            return {key: kept[key] for key in kept.files} if kept.files else None
    try:
        run, grows = _simulated(name, scene, overrides, drag)
    except DrillTwinError:
        np.savez(path)
        return None
    found = {**_signals(run), **truth_of(run, grows)}
    np.savez_compressed(path, **found)
    return found


def _simulated(name: str, scene: str, overrides: dict[str, str], drag: float | None) -> tuple[runs.Run, bool | None]:
    """A run, and whether a lateral mode grows under its final load; None where the modes are not known."""
    own = parse_scene(scene, name=name, overrides=dict(overrides))
    if drag is not None:  # a scene refuses a negative drag; here the growth is what is asked for
        held = own.effects.drag.model_copy(update={"linear": drag})
        own = own.model_copy(update={"effects": own.effects.model_copy(update={"drag": held})})
    try:
        grows = bool(modes(own, count=4).growing.get("lateral", 0)) if own.length < 100.0 else None
    except DrillTwinError:
        grows = None
    return runs.of_scene(name, own), grows


def _signals(run: runs.Run) -> dict[str, Any]:
    marks = [
        (mark.name, mark.on, mark.distance_from_bit, mark.wall_offset, mark.clearance, mark.inclined)
        for mark in run.marks
    ]
    return {
        "marks": np.array(json.dumps(marks)), "time": run.time, "speed": run.top_speed, "spin": run.mark_spin,
        "centre": run.mark_centre,
    }  # fmt: skip


def _record(number: int, name: str, found: dict[str, Any]) -> FrozenRecord:
    marks = tuple(
        MarkInfo(label, distance, on, arm, clearance, bool(inclined))
        for label, on, distance, arm, clearance, inclined in json.loads(str(found["marks"]))
    )
    draw = np.random.default_rng([FIRST + number, ord("s")])
    time, speed = found["time"], found["speed"]
    angle = np.concatenate(([0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(time))))
    samples = Turning(time, angle, speed, math.copysign(1.0, float(speed[-1])))
    motion, *of_marks = (tuple(names.tolist()) for names in found["states"])
    truth = Truth(
        found["at"], found["turns"], found["amplitude"], np.zeros_like(found["amplitude"]), motion, tuple(of_marks),
        float(found["ratio"]) if np.isfinite(found["ratio"]) else None, bool(found["scored"]),
        dated=bool(found["dated"]),
    )  # fmt: skip
    errors = Errors(float(draw.uniform(0.001, 0.01)))
    clearance = np.array([mark.clearance for mark in marks])
    return measured("s", name, marks, samples, found["centre"] / clearance, truth, errors, draw, sees_spin=True,
                      spin=found["spin"])  # fmt: skip


def truth_of(run: runs.Run, grows: bool | None) -> dict[str, Any]:
    """Truth of a run (module docstring)."""
    speed = np.abs(run.top_speed)
    turned = np.concatenate(([0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(run.time)))) / math.tau
    steps = np.arange(0.0, turned[-1], 1.0 / STEPS)
    moving = np.searchsorted(turned, 1e-6)
    time = np.interp(steps, turned[moving:], run.time[moving:])
    sense = math.copysign(1.0, float(run.top_speed[-1]))
    clearance, vertical = np.array([mark.clearance for mark in run.marks]), not any(mark.inclined for mark in run.marks)
    marks = _rest(_at(run.mark_centre / clearance, run.time, time), _at(run.mark_spin, run.time, time), vertical)
    nodes = _rest(_at(run.centre / run.clearance, run.time, time), _at(run.spin, run.time, time), vertical)
    size = np.stack([_amplitude(marks[:, k]) for k in range(clearance.size)], axis=1)
    lead = int(np.argmax(size.max(axis=0)))
    power = np.abs(np.fft.fft(marks[size[:, lead] >= 0.5 * size[:, lead].max(), lead])) ** 2
    half = power.size // 2
    forward, backward = float(power[1:half].sum()), float(power[half + 1 :].sum())
    one_sided = max(forward, backward) / max(forward + backward, 1e-300)
    around = _at(run.mark_centre, run.time, time)
    turns = float(np.ptp(np.unwrap(np.angle(around), axis=0), axis=0).max()) / math.tau
    large, small = bool(size.max() >= LARGE), bool(size.max() <= SMALL)
    whirls = large and (vertical or one_sided >= 0.9) and (vertical or turns > 0.25)
    still = not grows and (small or (not vertical and (one_sided <= 2.0 / 3.0 or turns <= 0.25)))
    touch = _at((np.abs(run.mark_centre) > 0.98 * clearance).astype(float), run.time, time) > 0.5
    node_touch = _at((np.abs(run.centre) > 0.98 * run.clearance).astype(float), run.time, time) > 0.5
    rolling = np.array([mark.rolling_ratio for mark in run.marks])
    grid = range(0, steps.size, STEPS // PER_TURN)
    states = [[], *([] for _ in clearance)]  # type: list[list[str]]
    ratios = []
    for i in grid:
        rows = slice(max(i - round(WINDOW * STEPS), 0), i + round(WINDOW * STEPS) + 1)
        shape, ratio = _string_state(nodes[rows], node_touch[rows], float(rolling.mean()), sense)
        # What still grows looks uneven, so that its window shows no state.
        grown = size[rows.start] > 0.5 * size[min(rows.stop, steps.size) - 1]
        states[0].append((shape if grown[lead] else "") or _before(size[i].max()))
        if size[i].max() > 0.5 * LARGE:
            ratios.append(ratio)
        for k in range(clearance.size):
            own = _state(marks[rows, k], touch[rows, k], float(rolling[k]), sense)[0]
            states[1 + k].append((own if grown[k] else "") or _before(size[i, k]))
    if not whirls:  # what moves without a whirl, as in the fall to the low side, has no state that is certain
        quiet = [float(np.abs(nodes[max(i - STEPS, 0) : i + STEPS]).max()) <= SMALL for i in grid]
        states = [[FIXED if calm else "" for calm in quiet] for _ in states]
        size = np.zeros_like(size)
    last = np.array(ratios[len(ratios) // 2 :])
    steady = last.size > 0 and float(np.ptp(last)) < 0.1 * float(np.abs(np.median(last)))
    return {
        "at": time[grid], "turns": steps[grid], "amplitude": size[grid], "states": np.array(states),
        "ratio": np.array(float(np.median(last)) if whirls and steady else math.nan),
        "scored": np.array(whirls or still), "dated": np.array(bool(size[STEPS].max() <= SMALL)),
        "facts": np.array([size.max(), one_sided, turns, math.nan if grows is None else float(grows)]),
    }  # fmt: skip


def _before(size: float) -> str:
    """State of what has not grown: none is true from `SMALL` on until a window shows one."""
    return FIXED if size <= SMALL else ""


def _at(values: Any, time: Array, wanted: Array) -> Any:
    """Values, shape (T, k), at wanted times."""
    return np.stack([np.interp(wanted, time, values[:, k]) for k in range(values.shape[1])], axis=1)


def _rest(z: ComplexArray, spin: Array, vertical: bool) -> ComplexArray:
    """Motion without its part that turns with the spin and, in an inclined hole, its mean; shapes (n, k)."""
    if not vertical:
        z = z - z[z.shape[0] // 4 :].mean(axis=0)
    count = round(HALF * STEPS)
    kernel = np.hanning(2 * count + 1)[:, None]
    seen = z * np.exp(-1j * spin)
    weight = fftconvolve(np.ones((z.shape[0], 1)), kernel, mode="same", axes=0)
    part: ComplexArray = fftconvolve(seen, kernel, mode="same", axes=0) / weight
    found: ComplexArray = z - part * np.exp(1j * spin)
    return found


def _amplitude(rest: ComplexArray) -> Array:
    """Amplitude that never falls up to its largest value, and stays there, shape (n,)."""
    size = np.sqrt(uniform_filter1d(np.abs(rest) ** 2, round(SMOOTH * STEPS)))
    top = int(np.argmax(size))
    grown = np.log(np.maximum(size, 1e-9))
    grown[: top + 1] = isotonic_regression(grown[: top + 1]).x
    grown[top:] = grown[top]
    found: Array = np.exp(grown)
    return found


def _state(a: ComplexArray, touching: Mask, rolling: float, sense: float) -> tuple[str, float]:
    """State of one point in a window, empty where it is not clear, and its whirl ratio."""
    radius = np.abs(a)
    if not radius.mean() > SMALL:
        return "", math.nan
    way = np.unwrap(np.angle(a))
    pace = float(np.angle((a[1:] * a[:-1].conj()).sum()))
    back = a * np.exp(-1j * pace * np.arange(a.size))
    coherence, uneven = float(abs(back.sum()) / radius.sum()), float(radius.std() / radius.mean())
    ratio = sense * pace * STEPS / math.tau
    touch, turns = float(touching.mean()), a.size / STEPS
    strikes = float((np.diff(touching.astype(int)) > 0).sum()) / turns
    high, even = CLEAR["regular"]
    if coherence < BROKEN:
        return IRREGULAR, ratio
    if strikes >= STRIKES and touch < 0.4 and coherence > 0.8 and uneven > 0.1:
        return IMPACTS, ratio
    if coherence < high or uneven > even or abs(np.ptp(way)) < 1.0:
        return "", ratio
    if touch > CLEAR["touching"][0] and ratio < 0.0:
        slip = abs(1.0 - ratio / rolling)
        return (ROLLING if slip < CLEAR["slip"][0] else CREEP if slip > CLEAR["slip"][1] else ""), ratio
    if abs(ratio) < SLOW or (touch > CLEAR["touching"][1] and ratio < 0.0):
        return "", ratio
    return (FORWARD if ratio > 0.0 else BACKWARD), ratio


def _string_state(a: ComplexArray, touching: Mask, rolling: float, sense: float) -> tuple[str, float]:
    """State of the string in a window from all nodes, shape (n, k), and its whirl ratio."""
    lead = int(np.argmax((np.abs(a) ** 2).sum(axis=0)))
    name, ratio = _state(a[:, lead], touching[:, lead], rolling, sense)
    if name in {"", IRREGULAR}:
        return name, ratio
    shape = np.linalg.svd(a, full_matrices=False)[2][0]
    square = (shape**2).sum()
    planarity = float(abs(square) / (np.abs(shape) ** 2).sum())
    plane = (shape * np.exp(-0.5j * np.angle(square))).real
    low, high = sorted((float(plane.max()), float(-plane.min())))
    if planarity < CLEAR["plane"][1]:
        return SPIRAL, ratio
    if planarity < CLEAR["plane"][0] or CLEAR["lobe"][1] <= max(low, 0.0) / high <= CLEAR["lobe"][0]:
        return "", ratio
    return (BENDING if low > CLEAR["lobe"][0] * high else name), ratio


def plans() -> Sequence[str]:
    """Names of the frozen runs, with their overrides: what is frozen of them."""
    return [f"{name}: {sorted(overrides.items())}, {drag}" for name, _, overrides, drag in _plans()]
