# SPDX-License-Identifier: Apache-2.0
"""The frozen kinematic records: eight kinds, each drawn by seeds on which nothing was tuned."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np

from drill_twin.core.arrays import Array, ComplexArray
from drill_twin.whirl import MarkInfo
from drill_twin_evidence.detection.frozen.measured import (
    HOLES,
    Errors,
    Turning,
    draw_errors,
    draw_marks,
    measured,
    turning,
)  # fmt: skip
from drill_twin_evidence.detection.frozen.motions import (
    Motion,
    assembled,
    draw_motion,
    ellipse,
    exponential,
    linear,
    resting,
    within,
)  # fmt: skip
from drill_twin_evidence.detection.frozen.run_ups import run_up
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
    SWING,
    FrozenRecord,
    Truth,
)  # fmt: skip

BASE = 4_500_000
"""First seed of the frozen records. Nothing was tuned on it or on those after it; the plain detector was tuned on seeds
from 8,100,000 on."""
EACH = 40
"""Records of each kind."""
KINDS = {
    "a": "low side of an inclined hole",
    "b": "run-ups through a critical speed",
    "c": "slow growth",
    "d": "creep and rolling on the wall",
    "e": "planes, ellipses, two whirls, vertical",
    "f": "clocks",
    "g": "coloured noise",
    "h": "impacts",
    "s": "simulated",
}
"""Kinds of records."""
REGULAR = (FORWARD, BACKWARD, BENDING, SPIRAL)
ANY = (*REGULAR, ROLLING, IRREGULAR, CREEP, IMPACTS)


def frozen_records(
    kinds: str = "abcdefghs", *, each: int = EACH, base: int = BASE, share: int = 1
) -> Iterator[FrozenRecord]:
    """The frozen records, kind by kind, always the same.

    Args:
        kinds: Letters of the kinds, as in `KINDS`.
        each: Records of each kinematic kind.
        base: First seed; another for records to tune on, without simulated runs.
        share: Take every so-manieth record only, for a quick look.
    """
    for kind in kinds:
        if kind == "s":
            from drill_twin_evidence.detection.frozen.simulated import simulated_records

            if base == BASE:
                yield from simulated_records(share)
            continue
        for number in range(0, each, share):
            yield _MAKERS[kind](number, np.random.default_rng([base + number, ord(kind)]))


def _low_side(number: int, draw: np.random.Generator) -> FrozenRecord:
    """Swings in a plane, ellipses, whirls that grow on the low side or go all round, and strings that lie still."""
    marks, samples = draw_marks(draw, int(draw.integers(3)), inclined=True), turning(draw, 90.0)
    case = number % 8
    axes = (0.0, draw.uniform(0.0, 0.15), draw.uniform(0.16, 0.44), draw.uniform(0.45, 1.0), 1.0, 1.0, 1.0, 0.0)[case]
    ratio = float(draw.choice([draw.uniform(0.12, 0.85), draw.uniform(1.15, 1.8)]) * draw.choice([-1.0, 1.0]))
    depth, level = draw.uniform(0.45, 0.65), draw.uniform(0.1, 0.24)
    swings = axes <= 0.15
    state = SWING if swings else FORWARD if ratio > 0.0 else BACKWARD
    shape = (1.0 - draw.uniform(0.0, 0.4) * np.linspace(0.0, 1.0, len(marks))).astype(complex)
    motion = Motion(state, ratio, ellipse(samples, ratio, axes, draw), level, shape, scored=swings or axes >= 0.45)
    quiet = draw.uniform(12.0, 20.0)
    size = exponential(samples, level, np.exp(draw.uniform(math.log(0.15), math.log(2.0))), quiet)
    if case == 7:  # lies still
        size = np.full(samples.time.size, 1e-6)
    elif case == 1:  # swings from the first sample on
        size = np.full(samples.time.size, level)
    part, truth = assembled(samples, [motion], size)
    low = np.full(samples.time.size, depth)
    if case == 6:  # leaves the low side and goes all round
        part, truth = part * 3.0, _scaled(truth, 3.0)
        low = depth * (1.0 - np.clip(size / level, 0.0, 1.0))
    centre = within(low[:, None] + part + resting(samples, draw, 0.02, 0.05, len(marks)))
    name = f"{number}: {state}, half axes {axes:.2f}, ratio {ratio:.2f}, case {case}"
    return measured("a", name, marks, samples, centre, truth, draw_errors(draw, 0.02), draw)


def _scaled(truth: Truth, factor: float) -> Truth:
    return Truth(
        truth.time, truth.turns, truth.amplitude * factor, truth.moving * factor, truth.motion, truth.marks, truth.ratio
    )


def _slow(number: int, draw: np.random.Generator) -> FrozenRecord:
    """Growth by e in 2.5 to 50 revolutions, and orbits that take 5 to 20 revolutions from 0.025 to 0.1."""
    state = REGULAR[number // 2 % 4]
    pace = np.exp(draw.uniform(math.log(0.02), math.log(0.4))) if number % 2 else 0.075 / draw.uniform(5.0, 20.0)
    quiet, marks = draw.uniform(12.0, 20.0), draw_marks(draw)
    length = quiet + 20.0 + (5.5 / pace if number % 2 else 0.8 / pace)
    samples = turning(draw, length, float(np.exp(draw.uniform(math.log(14.0), math.log(40.0)))))
    motion = draw_motion(state, samples, marks, draw)
    size = (exponential if number % 2 else linear)(samples, motion.level, pace, quiet)
    part, truth = assembled(samples, [motion], size)
    centre = within(part + resting(samples, draw, 0.15, 0.08, len(marks)))
    name = f"{number}: {state}, ratio {motion.ratio:.2f}, {'growth' if number % 2 else 'slope'} {pace:.3f} in a turn"
    return measured("c", name, marks, samples, centre, truth, draw_errors(draw, 0.02), draw)


def _wall(number: int, draw: np.random.Generator) -> FrozenRecord:
    """Creep at -0.3 to -0.005 of the rotation, rolling at up to -32 times, and creep that becomes rolling."""
    states = ((CREEP,), (ROLLING,), (CREEP, ROLLING), (CREEP,))[number % 4]
    holes = range(len(HOLES)) if states == (ROLLING,) else (1, 2, 3, 4)
    marks = draw_marks(draw, int(draw.choice([*holes])))
    fastest = abs(marks[0].rolling_ratio) * 1.1 if ROLLING in states else 1.0
    probe = draw_motion(CREEP, turning(draw, 1.0), marks, draw, 0.005).ratio or -0.1
    hold = max(26.0, 0.6 / abs(probe)) if states[0] == CREEP else 26.0
    quiet, growth = draw.uniform(12.0, 18.0), np.exp(draw.uniform(math.log(0.3), math.log(3.0)))
    reached = quiet + 5.6 / growth
    length = reached + hold + (30.0 if len(states) > 1 else 0.0)
    samples = turning(draw, length, max(3.5 * fastest, float(np.exp(draw.uniform(math.log(16.0), math.log(40.0))))))
    motions = [draw_motion(state, samples, marks, draw) for state in states]
    if states[0] == CREEP:
        motions[0] = motions[0]._replace(ratio=probe, path=ellipse(samples, probe, 1.0, draw))
    part, truth = assembled(samples, motions, exponential(samples, 1.0, growth, quiet, to_wall=True), reached + hold)
    centre = within(part * 1.03 + resting(samples, draw, 0.0, 0.02, len(marks)))
    name = f"{number}: {' then '.join(states)}, ratio {motions[-1].ratio:.3f}, rolling {marks[0].rolling_ratio:.2f}"
    return measured("d", name, marks, samples, centre, truth, draw_errors(draw, 0.02), draw)


def _planes(number: int, draw: np.random.Generator) -> FrozenRecord:
    """In a vertical hole: swings in a plane, ellipses, two whirls at once, irregular paths."""
    marks, samples, case = draw_marks(draw), turning(draw, 80.0), number % 8
    ratio = float(draw.choice([draw.uniform(0.12, 0.85), draw.uniform(1.15, 1.8)]) * draw.choice([-1.0, 1.0]))
    axes = (0.0, draw.uniform(0.0, 0.15), draw.uniform(0.45, 0.7), draw.uniform(0.7, 0.95), draw.uniform(0.16, 0.44))
    level = draw.uniform(0.12, 0.6)
    shape = (1.0 - draw.uniform(0.0, 0.4) * np.linspace(0.0, 1.0, len(marks))).astype(complex)
    sense = FORWARD if ratio > 0.0 else BACKWARD
    if case < 5:
        oval = axes[case]
        state = SWING if oval <= 0.15 else sense
        motion = Motion(state, ratio, ellipse(samples, ratio, oval, draw), level, shape, scored=case != 4)
        name = f"{number}: {state}, half axes {oval:.2f}, ratio {ratio:.2f}"
    elif case < 7:
        other, part_of = float(draw.uniform(-1.5, 1.5)), draw.uniform(0.3, 0.55)
        if abs(other - ratio) < 0.2 or abs(other - 1.0) < 0.1:
            other = -ratio
        path = ellipse(samples, ratio, 1.0, draw) + part_of * ellipse(samples, other, 1.0, draw)
        motion = Motion(sense, ratio, path / math.hypot(1.0, part_of), level, shape)
        name = f"{number}: two whirls, {ratio:.2f} and {part_of:.2f} of it at {other:.2f}"
    else:
        motion = draw_motion(IRREGULAR, samples, marks, draw)
        name = f"{number}: irregular"
    growth = np.exp(draw.uniform(math.log(0.3), math.log(3.0)))
    part, truth = assembled(samples, [motion], exponential(samples, motion.level, growth, draw.uniform(12.0, 18.0)))
    centre = within(part + resting(samples, draw, 0.1, 0.06, len(marks)))
    return measured("e", name, marks, samples, centre, truth, draw_errors(draw), draw)


def _clocks(number: int, draw: np.random.Generator) -> FrozenRecord:
    """Any motion, and none, seen through a clock with jitter, drift, gaps or stamps that come twice, 20 Hz to 2 kHz."""
    rate = float(np.exp(draw.uniform(math.log(20.0), math.log(2000.0))))
    marks, state = draw_marks(draw, int(draw.integers(3))), (*ANY, FIXED)[number % 9]
    fastest = max(8.0, 3.5 * 1.1 * abs(marks[0].rolling_ratio)) if state == ROLLING else 8.0
    speed = float(np.clip(np.exp(draw.uniform(math.log(0.7), math.log(5.0))), rate / 400.0, rate / fastest))
    sense = float(draw.choice([-1.0, 1.0]))
    time = np.arange(int(70.0 / speed * rate)) / rate
    jitter = draw.uniform(0.0, 0.45) / rate
    time = np.sort(time + draw.normal(size=time.size) * jitter)
    time -= time[0]
    samples = Turning(time, sense * math.tau * speed * time, np.full(time.size, sense * math.tau * speed), sense)
    drift, wave = draw.uniform(-2e-3, 2e-3), draw.uniform(0.0, 0.01) / speed
    stamps = 1.7e9 * (number % 2) + time * (1.0 + drift) + wave * np.sin(math.tau * speed / 30.0 * time)
    kept = draw.random(time.size) >= draw.uniform(0.0, 0.15)
    for _ in range(int(draw.integers(0, 4))):
        at = draw.uniform(0.0, 70.0)
        kept &= np.abs(samples.turns - at) > 0.5 * draw.uniform(0.2, 3.0)
    rows = np.flatnonzero(kept)
    twice = draw.random(rows.size) < draw.choice([0.0, draw.uniform(0.0, 0.1)])
    rows = np.repeat(rows, 1 + twice).astype(np.int64)
    part, truth = _drawn(state, samples, marks, draw, stamps)
    centre = within(part + resting(samples, draw, 0.0 if state in {ROLLING, CREEP} else 0.1, 0.02, len(marks)))
    name = f"{number}: {state}, {rate:.0f} Hz, {rate / speed:.0f} in a turn, jitter {jitter * rate:.2f}"
    return measured("f", name, marks, samples, centre, truth, draw_errors(draw, 0.02), draw, stamps=stamps, kept=rows)


def _drawn(
    state: str, samples: Turning, marks: tuple[MarkInfo, ...], draw: np.random.Generator, stamps: Array | None = None
) -> tuple[ComplexArray, Truth]:
    """A motion that grows at a random pace, in half of the records followed by another; or none."""
    if state == FIXED:
        still = Motion(FIXED, None, np.ones(samples.time.size, complex), 1e-6, np.ones(len(marks), complex))
        return assembled(samples, [still], np.full(samples.time.size, 1e-6), stamps=stamps)
    motions = [draw_motion(state, samples, marks, draw)]
    growth = np.exp(draw.uniform(math.log(0.4), math.log(4.0)))
    quiet = draw.uniform(12.0, 16.0)
    size = exponential(samples, motions[0].level, growth, quiet, to_wall=motions[0].level == 1.0)
    if draw.random() < 0.5:
        motions.append(draw_motion(str(draw.choice([*REGULAR, IRREGULAR])), samples, marks, draw))
    return assembled(samples, motions, size, max(45.0, quiet + 7.0 / growth + 15.0), stamps)


def _noisy(number: int, draw: np.random.Generator) -> FrozenRecord:
    """Any motion, in every third record none, in noise whose power falls with frequency, quantised, with outliers."""
    state = FIXED if number % 3 == 2 else ANY[number // 3 % len(ANY)]
    marks = draw_marks(draw, int(draw.integers(3)))
    fastest = 3.5 * 1.1 * abs(marks[0].rolling_ratio) if state == ROLLING else 8.0
    samples = turning(draw, 75.0, max(fastest, float(np.exp(draw.uniform(math.log(12.0), math.log(80.0))))))
    part, truth = _drawn(state, samples, marks, draw)
    still = state == FIXED
    centre = within(part + resting(samples, draw, 0.3 if still else 0.0, 0.1 if still else 0.02, len(marks)))
    errors = Errors(
        float(draw.uniform(0.005, 0.05 if still else 0.03)), float(draw.uniform(0.0, 1.5)),
        float(draw.uniform(0.0, 0.03)), float(draw.uniform(0.0, 0.15)), float(draw.choice([0.0, 0.002])),
    )  # fmt: skip
    name = f"{number}: {state}, noise {errors.noise:.3f} of colour {errors.colour:.1f}"
    return measured("g", name, marks, samples, centre, truth, errors, draw)


def _impacts(number: int, draw: np.random.Generator) -> FrozenRecord:
    """Whirl that strikes the wall again and again; and single shocks, after which a string swings and comes to rest."""
    marks, samples = draw_marks(draw, int(draw.integers(3))), turning(draw, 75.0, draw.uniform(24.0, 60.0))
    if number % 2:
        motion = draw_motion(IMPACTS, samples, marks, draw)
        growth, quiet = np.exp(draw.uniform(math.log(0.4), math.log(3.0))), draw.uniform(12.0, 18.0)
        part, truth = assembled(samples, [motion], exponential(samples, 1.0, growth, quiet, to_wall=True))
        name = f"{number}: {IMPACTS}, ratio {motion.ratio:.2f}"
        centre = within(part + resting(samples, draw, 0.0, 0.02, len(marks)))
        return measured("h", name, marks, samples, centre, truth, draw_errors(draw, 0.02), draw)
    part, truth = _drawn(FIXED, samples, marks, draw)
    turns, labels = samples.turns, np.array(truth.motion, object)
    for at in np.sort(draw.uniform(8.0, 70.0, int(draw.integers(1, 6)))):
        since, own, dies = np.maximum(turns - at, 0.0), draw.uniform(0.4, 3.0), draw.uniform(0.15, 0.5)
        height = draw.uniform(0.08, 0.5) * np.exp(1j * draw.uniform(0.0, math.tau))
        part = part + (height * np.exp(-since / dies) * np.sin(math.tau * own * since))[:, None]
        labels[(truth.turns > at - 0.5) & (truth.turns < at + 8.0 * dies)] = ""
    truth = Truth(truth.time, truth.turns, truth.amplitude, truth.moving, tuple(labels), (tuple(labels),) * len(marks))
    centre = within(part + resting(samples, draw, 0.3, 0.08, len(marks)))
    return measured("h", f"{number}: single shocks", marks, samples, centre, truth, draw_errors(draw, 0.02), draw)


_MAKERS: dict[str, Callable[[int, np.random.Generator], FrozenRecord]] = {
    "a": _low_side, "b": run_up, "c": _slow, "d": _wall, "e": _planes, "f": _clocks, "g": _noisy, "h": _impacts,
}  # fmt: skip
__all__ = ["BASE", "EACH", "KINDS", "PER_TURN", "frozen_records"]
