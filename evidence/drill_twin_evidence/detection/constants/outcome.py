# SPDX-License-Identifier: Apache-2.0
"""Findings of the whirl analysis in held-out records, signals of a sub and spectra, in one process.

    python -m drill_twin_evidence.detection.constants.outcome RECORDS

prints one line of JSON. The process is started with the folder of a varied package first in its path.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
import math
import pickle
import sys
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from typing_extensions import TypedDict

from drill_twin.core.arrays import Array
from drill_twin.whirl import Analyzer
from drill_twin.whirl.downhole import SubAnalyzer
from drill_twin.whirl.severity import accelerations, sizes, turns_backwards
from drill_twin.whirl.spectrum import lines_of, spectrum_over_time
from drill_twin_evidence.detection.frozen import Finding, FrozenRecord, frozen_records, score_of
from drill_twin_evidence.detection.frozen.score import finding_of
from drill_twin_evidence.detection.sub_signals import SubSignal, drawn_signal

BASE = 5_600_000
"""First seed of the records; nothing was tuned on it or on those after it."""
KINDS, MANIFOLD = "bcdfgh", "ae"
"""Kinds of records; the latter have eight cases, and so twice as many records."""
SUBS = 3
"""Signals of a sub, at most, and at most as many as records of a kind: the first seeds from `BASE` on."""
SPECTRA = 8
"""Records of which the spectrum is compared: the first."""
DIGITS = 6
"""Significant digits of a number that is compared, so that round-off is no change."""


class Outcome(TypedDict):
    """Findings of the analysis, scored and digested."""

    half: int
    """Onsets within half a revolution."""
    onsets: int
    missed: int
    false: int
    f1: float
    """Mean F1 of the string's states."""
    marks: float
    """Mean F1 of the states of the marks."""
    digests: dict[str, str]
    """Digest of all that is said, by part of the analysis: `marks`, `bit`, `sub`, `spectrum`."""


class Material(NamedTuple):
    """Held-out records and signals."""

    records: list[FrozenRecord]
    subs: list[SubSignal]


def material(each: int) -> Material:
    """Records, so many of each kind or twice as many, and signals of a sub."""
    subs = [drawn_signal(BASE + number) for number in range(min(SUBS, each))]
    records = [*frozen_records(KINDS, each=each, base=BASE), *frozen_records(MANIFOLD, each=2 * each, base=BASE)]
    return Material(records, subs)


def outcome_of(found: Material) -> Outcome:
    """Findings of the analysis in records and signals."""
    said: dict[str, list[Any]] = {"marks": [], "bit": [], "sub": [], "spectrum": []}

    def detect(record: FrozenRecord) -> Finding:
        analyzer = Analyzer(record.marks)
        bit = _bit_speed(record, len(said["marks"]))
        analyzer.push_block(record.stamp, record.position, record.spin, record.top_speed, bit_speed=bit)
        summary = analyzer.summary()
        torsion = ("stick_slip", "bit", "stick_slip_index", "largest_stick_slip_index")
        whole = _plain(summary)
        said["bit"].append([*(whole.pop(name) for name in torsion), int(turns_backwards(bit, record.top_speed).sum())])
        said["marks"].append([whole, _plain(analyzer.findings)])
        if len(said["spectrum"]) < SPECTRA:
            said["spectrum"].append(_spectrum(record))
        return finding_of(summary)

    scores = score_of(found.records, detect)["all"]
    for sub in found.subs:
        analyzer = SubAnalyzer(sub.mark, sub.radius, sub.noise)
        for stamp, values in zip(sub.stamp.tolist(), sub.readings, strict=True):
            analyzer.push(stamp, values)
        said["sub"].append([_plain(analyzer.summary()), _plain(analyzer.sub)])
    plain = scores.plain()
    return Outcome(
        half=plain["half"], onsets=plain["onsets"], missed=plain["missed"], false=plain["false"],
        f1=plain["string"] or 0.0, marks=plain["marks"] or 0.0,
        digests={part: hashlib.sha256(repr(rows).encode()).hexdigest()[:12] for part, rows in said.items()},
    )  # fmt: skip


def _bit_speed(record: FrozenRecord, number: int) -> Array:
    """Speed of a bit [rad/s] that follows the top drive, swings, sticks, or swings less and less, in turn."""
    time = 1e-9 * (record.stamp - record.stamp[0])
    size = (0.0, 0.7, 1.3, 1.5 * np.exp(-0.08 * time))[number % 4]
    noise = 0.01 * np.random.default_rng(number).normal(size=time.size)
    bit: Array = record.top_speed * (1.0 + size * np.sin(math.tau * (0.15 + 0.02 * (number % 7)) * time) + noise)
    return np.sign(record.top_speed) * np.maximum(np.sign(record.top_speed) * bit, 0.0) if number % 8 == 2 else bit


def _spectrum(record: FrozenRecord) -> list[Any]:
    """Lines, spectra over time and acceleration of the first mark of a record."""
    time, place = 1e-9 * (record.stamp - record.stamp[0]), record.position[:, 0]
    seen = np.isfinite(place).all(axis=1) & np.diff(time, prepend=-1.0).astype(bool)
    time, centre = time[seen], place[seen, 0] + 1j * place[seen, 1]
    rotation = float(record.top_speed.mean()) / math.tau
    over = [part[::40].round(9) for part in spectrum_over_time(time, centre, 10.0 / abs(rotation))]
    step, found = accelerations(time, centre)
    said: list[Any] = _plain(
        [lines_of(time, centre, rotation), [part.shape for part in over], over[2], step, sizes(found)]
    )
    return said


def _plain(value: Any) -> Any:
    """Plain types, with numbers of `DIGITS` digits."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {field.name: _plain(getattr(value, field.name)) for field in dataclasses.fields(value)}
    if isinstance(value, dict):
        return {str(key): _plain(one) for key, one in value.items()}
    if isinstance(value, np.ndarray):
        return _plain(value.tolist())
    if isinstance(value, list | tuple):
        return [_plain(one) for one in value]
    if isinstance(value, complex):
        return [_plain(value.real), _plain(value.imag)]
    return f"{value:.{DIGITS}g}" if isinstance(value, float) else str(value)


if __name__ == "__main__":
    print(json.dumps(outcome_of(pickle.loads(Path(sys.argv[1]).read_bytes()))))  # noqa: S301 written by the parent
