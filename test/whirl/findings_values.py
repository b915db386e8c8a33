# SPDX-License-Identifier: Apache-2.0
"""Findings of labelled motions, kept with tolerances that hold on every processor.

    python test/whirl/findings_values.py            # compare with findings_values.json
    python test/whirl/findings_values.py --write    # after a change that is meant to alter results

Findings are kept after every two hundredth sample, and the summary. Numbers differ by no more than 1e-7 of themselves
or 1e-10, so a motion state, a count or an onset that moves by a sample is seen.
"""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass, replace
from enum import Enum
from functools import partial
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np
from kinematics import BENCH, MARKS, Motion, clock, growth, motion

from drill_twin.whirl import Analyzer, Findings, MarkInfo

FILE = Path(__file__).with_suffix(".json")
EVERY = 200  # samples
RELATIVE, ABSOLUTE = 1e-7, 1e-10
THREE = tuple(MarkInfo(name, height, "wall", 0.00825, 0.08175) for name, height in (("a", 4.0), ("b", 3.0), ("c", 2.0)))
MANY = tuple(replace(MARKS[k % 4], name=f"m{k}", distance_from_bit=0.4 * (k // 2)) for k in range(9))
INCLINED = tuple(replace(mark, inclined=True) for mark in THREE)
Sample = tuple[Any, ...]


def shaped(shape: Any, ratio: float, level: float = 0.7, rate: float = 3.0) -> Any:
    """Growth of a shape [complex, of the largest] at a ratio of the rotation."""
    grow = growth(5.0, 0.05, rate, ratio, limit=level)
    return lambda time, angle: grow(time, angle)[:, None] * np.asarray(shape)


def wander(time: Any, angle: Any) -> Any:
    """A motion with power at many ratios, that ends."""
    random = np.random.default_rng(4)
    lines = zip(random.uniform(-1.5, 2.5, 6), random.uniform(0, 6, 6), strict=True)
    return 0.2 * sum(np.exp(1j * (p * angle + a)) for p, a in lines) / (1.0 + np.exp(-3.0 * (time - 5.0)))


def passing(time: Any, angle: Any) -> Any:
    """A whirl that comes and goes, then another the other way round."""
    first, second = np.exp(-(((time - 8.0) / 1.5) ** 2)), np.exp(-(((time - 20.0) / 2.0) ** 2))
    return 0.6 * first * np.exp(0.45j * angle) + 0.4 * second * np.exp(-0.2j * angle)


def leaning(time: Any, angle: Any) -> Any:
    """A string that leans over in steps, and turns slowly from one place to the next."""
    place = np.interp(time, [0, 5, 7, 12, 13, 22, 30], [0, 0, 20, 40, 100, 170, 400])
    return 0.4 / (1.0 + np.exp(-4.0 * (time - 5.0))) * np.exp(1j * np.radians(place)) * (1.0 + 0.0 * angle)


def samples(moved: Motion, *, spin: bool = True, force: bool = False, speed: bool = True) -> Iterator[Sample]:
    """Arguments of `Analyzer.push` for a motion, with the bit in stick-slip."""
    positions, stamps = moved.positions, moved.stamps.tolist()
    contact = (np.abs(moved.centre) > 0.5 * moved.marks[0].clearance) * 3.0
    bit = moved.top_speed * (1.0 - np.cos(2.0 * moved.time) * (moved.time > 4.0) * (moved.time < 25.0))
    for i, stamp in enumerate(stamps):
        turned, top = moved.spin[i] if spin else None, float(moved.top_speed[i]) if speed else np.nan
        yield stamp, positions[i], turned, top, contact[i] if force else None, float(bit[i])


def damaged(moved: Motion) -> Iterator[Sample]:
    """The samples of a motion with all that can go wrong with a stream."""
    random, last = np.random.default_rng(7), None
    for i, (stamp, place, *rest) in enumerate(samples(moved)):
        if 900 < i < 1000 or 1300 < i < 1320:
            continue
        position = place.copy()
        position[random.uniform(size=len(position)) < 0.1] = np.nan
        position[0, 0] += 5.0 * (i % 50 == 1)
        if i % 10 == 8:
            rest[0] = None
        if i % 17 == 3:
            rest[1] = np.nan
        if i % 23 == 4:
            rest[2] = np.abs(position[:, 0])
        if i % 31 == 5:
            rest[3] = np.inf
        yield stamp, position, *rest
        if i % 9 == 2:
            yield stamp, position, *rest
        if i % 9 == 4 and last is not None:
            yield last - 1, position, *rest
        last = stamp


def cases() -> dict[str, tuple[tuple[MarkInfo, ...], Callable[[], Iterator[Sample]]]]:
    """Name -> marks and samples."""
    helix = np.exp(1j * np.arange(3))
    rolling = shaped([1.0, 1.0, 1.0], BENCH.rolling_ratio, 1.0)
    time, fast = clock(100, 24, jitter=0.1), clock(400, 12)
    three = partial(motion, time, marks=THREE, bow=0.03)
    found = {
        "steady": motion(time, marks=THREE, bow=0.2, offset=0.4).with_noise(0.05, 1),
        "forward": three(whirl=shaped([0.8, 1.0, 0.9], 0.5)).with_noise(0.01, 2),
        "second bending": three(whirl=shaped([1.0, 0.1, -0.8], 0.5)).with_noise(0.01, 3),
        "spiral, to the left": three(speed=-2.0, whirl=shaped(helix, 0.5)).with_noise(0.01, 4),
        "without noise": three(whirl=shaped([0.8, 1.0, 0.9], -0.3)),
        "irregular": three(whirl=wander).with_noise(0.01, 5),
        "passing": three(whirl=passing).with_noise(0.005, 6),
        "slow": three(whirl=shaped([0.8, 1.0, 0.9], 0.03, rate=1.0)).with_noise(0.01, 7),
        "bow that grows": motion(time, marks=THREE, bow=0.05 + 0.6 / (1.0 + np.exp(-2.0 * (time - 8.0)))),
        "leaning": three(whirl=leaning).with_noise(0.005, 8),
        "nine marks": motion(time, marks=MANY, bow=0.03, whirl=growth(5.0, 0.05, 2.0, 0.4)).with_noise(0.01, 9),
        "one mark": motion(time, bow=0.03, whirl=passing).with_noise(0.01, 10),
        "fast samples": motion(fast, marks=THREE, speed=3.0, whirl=shaped([0.8, 1.0, 0.9], 0.6)).with_noise(0.03, 11),
        "rare samples": motion(clock(7, 40), marks=THREE, whirl=shaped([0.8, 1.0, 0.9], 0.3)).with_noise(0.01, 12),
        "slower than a bin": motion(clock(20, 60), marks=THREE, speed=0.06, bow=0.1).with_noise(0.01, 13),
        "inclined": motion(time, marks=INCLINED, bow=0.02, offset=0.9 * (1.0 - np.exp(-time / 0.1))[:, None],
                           whirl=growth(12.0, 0.05, 2.0, 0.5, limit=0.5)).with_noise(0.003, 14),
    }  # fmt: skip
    plain = {name: (moved.marks, partial(samples, moved)) for name, moved in found.items()}
    stopped = motion(np.append(time, time + 25.0), marks=THREE, speed=0.0)
    return plain | {
        "rolling, forces": (THREE, partial(samples, three(whirl=rolling).with_noise(0.01, 20), force=True)),
        "without spin": (MARKS, partial(samples, motion(time, marks=MARKS, bow=0.04, whirl=passing), spin=False)),
        "without spin, noise": (MANY, partial(samples, found["nine marks"], spin=False, force=True)),
        "rotation from the spin": (MANY, partial(samples, found["nine marks"], speed=False)),
        "damaged": (THREE, partial(damaged, found["passing"])),
        "damaged, irregular": (THREE, partial(damaged, found["irregular"])),
        "at rest": (THREE, partial(samples, stopped)),
    }


def bits(found: Findings) -> bytes:
    """All values of findings."""
    values = (getattr(found, field.name) for field in fields(Findings))
    return b"".join(v.tobytes() if isinstance(v, np.ndarray) else repr(v).encode() for v in values)


def plain(value: Any) -> Any:
    """A value as JSON has it; numbers that are missing as None, sentences left out."""
    if is_dataclass(value) and not isinstance(value, type):
        return {
            name: plain(part)
            for name, part in vars(value).items()
            if not name.endswith("criterion") and name != "notes"
        }
    if isinstance(value, Enum):
        return value.value
    if isinstance(value, dict):
        return {name: plain(part) for name, part in value.items()}
    if isinstance(value, (tuple, list, np.ndarray)):
        return [plain(part) for part in value]
    if isinstance(value, (float, np.floating)):
        return float(f"{value:.9g}") if math.isfinite(value) else None
    return value


def values(marks: tuple[MarkInfo, ...], pushed: Iterator[Sample]) -> dict[str, Any]:
    """Findings after every two hundredth sample, and the summary; a block gives the bits that its samples give."""
    analyzer, all_samples, kept = Analyzer(marks), list(pushed), []
    for first in range(1 - EVERY, len(all_samples), EVERY):
        block = all_samples[max(first, 0) : first + EVERY]
        for _, alike in groupby(block, key=lambda sample: tuple(part is None for part in sample)):
            columns = zip(*alike, strict=True)
            analyzer.push_block(*(None if column[0] is None else np.array(column) for column in columns))
        if first + EVERY <= len(all_samples):
            kept.append(plain(analyzer.findings))
            kept[-1].pop("marks")
    return {"findings": kept, "summary": plain(analyzer.summary())}


def difference(expected: Any, found: Any, place: str = "") -> str:
    """The first place at which values differ, in words; empty if they agree."""
    if isinstance(expected, dict) and isinstance(found, dict) and expected.keys() == found.keys():
        told = (difference(expected[name], found[name], f"{place}.{name}") for name in expected)
    elif isinstance(expected, list) and isinstance(found, list) and len(expected) == len(found):
        told = (
            difference(before, now, f"{place}[{number}]")
            for number, (before, now) in enumerate(zip(expected, found, strict=True))
        )
    else:
        numbers = isinstance(expected, float) and isinstance(found, (int, float))
        same = math.isclose(expected, found, rel_tol=RELATIVE, abs_tol=ABSOLUTE) if numbers else expected == found
        return "" if same else f"{place}: expected {expected!r}, found {found!r}"
    return next(filter(None, told), "")


def main() -> int:
    """Compare, or write."""
    found = {name: values(marks, pushed()) for name, (marks, pushed) in cases().items()}
    if "--write" in sys.argv:
        FILE.write_text(
            "{\n" + ",\n".join(f"{json.dumps(name)}: {json.dumps(found[name])}" for name in found) + "\n}\n"
        )
        return 0
    known = json.loads(FILE.read_text("utf-8"))
    changed = {name: difference(known.get(name), value) for name, value in found.items()}
    print("\n".join(f"{name}: {text or 'as before'}" for name, text in changed.items()))
    return 1 if any(changed.values()) else 0


if __name__ == "__main__":
    sys.exit(main())
