# SPDX-License-Identifier: Apache-2.0
"""Table of the published numbers and trends of the bench beside those of the twin."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from drill_twin.core.arrays import number_or_nan
from drill_twin_evidence.paper.runs.cases import LOAD, LOADS, REFERENCE, SPEED, SPEEDS, Case
from drill_twin_evidence.paper.runs.published import CRITICAL_TIME, DISPLACEMENT, FREQUENCY, RATIO, Number, published
from drill_twin_evidence.paper.runs.run import Measured, deviation

NEAR = 0.20
"""Relative deviation within which a number counts as reproduced."""
SLACK = 0.03
"""Relative step against a trend that is permitted: runs of one chaotic motion differ by as much."""

Results = Mapping[Case, Measured]


@dataclass(frozen=True)
class Row:
    """A published number and that of the twin."""

    number: Number
    ours: float | None
    """Number of the twin [unit]; None where the run has none or was not made."""
    deviation: float | None
    """Relative deviation [-]."""

    @property
    def near(self) -> bool:
        """True if the deviation is within 20 %."""
        return self.deviation is not None and abs(self.deviation) <= NEAR

    def to_dict(self) -> dict[str, Any]:
        """Plain types for JSON."""
        return {**asdict(self.number), "ours": self.ours, "deviation": self.deviation, "near": self.near}


@dataclass(frozen=True)
class Trend:
    """A published trend and that of the twin."""

    published: str
    ours: str
    right: bool

    def to_dict(self) -> dict[str, Any]:
        """Plain types for JSON."""
        return asdict(self)


def rows(results: Results) -> list[Row]:
    """Published numbers of the bench and those of the twin, for the runs available."""
    found = []
    for number in published().bench:
        ours = ours_for(number, results.get(number.case))
        found.append(Row(number, ours, deviation(ours, number.value)))
    return found


def ours_for(number: Number, measured: Measured | None) -> float | None:
    """Value of the twin for a published number; of a whirl frequency the size, because its sense is not published.

    A ratio has its sign, because the paper gives ratios of forward whirl.
    """
    if measured is None:
        return None
    if number.what == CRITICAL_TIME:
        return measured.onset_s
    if number.what == FREQUENCY:
        return None if measured.frequency_hz is None else abs(measured.frequency_hz)
    if number.what == RATIO:
        return measured.ratio
    if number.what == DISPLACEMENT:
        return measured.largest_mm[number.mark]
    raise ValueError(f"expected a quantity of the table, found {number.what!r}")


def surge_speed(results: Results) -> float | None:
    """Speed of the steepest rise of the ratio of whirl to rotation [rev/s]; None if no rise reaches a quarter."""
    known = [(c.speed, m.ratio) for c, m in _sweep(results, LOAD, SPEEDS) if m.ratio is not None]
    steps = [(b - a, 0.5 * (u + v)) for (u, a), (v, b) in pairwise(known)]
    rise, speed = max(steps, default=(0.0, 0.0))
    return speed if rise >= 0.25 else None


def trends(results: Results) -> list[Trend]:
    """Published trends and those of the twin."""
    speed_onset = _values(results, LOAD, SPEEDS, "onset_s")
    load_onset = _values(results, SPEED, LOADS, "onset_s")
    speed_frequency = _values(results, LOAD, SPEEDS, "frequency_hz")
    load_frequency = [(x, abs(y)) for x, y in _values(results, SPEED, LOADS, "frequency_hz")]
    low = [pair for pair in load_frequency if pair[0] <= 150.0]
    found = [
        Trend("critical time falls with speed", _listed(speed_onset, "s"), _falls(speed_onset)),
        _linear(speed_onset),
        Trend("critical time falls with weight on bit", _listed(load_onset, "s"), _falls(load_onset)),
        _flattens("critical time: steep at first, then flat", load_onset, "s"),
        Trend("whirl frequency rises with speed", _listed(speed_frequency, "Hz"), _falls(speed_frequency, -1.0)),
        Trend("whirl frequency falls with weight on bit to 150 N", _listed(low, "Hz"), _falls(low)),
        _flattens("whirl frequency: flat from 150 N", load_frequency, "Hz"),
        _surge(results),
    ]
    reference = results.get(REFERENCE)
    if reference is not None:
        size = [reference.largest_mm[mark] for mark in ("mark_3", "mark_2", "mark_1")]
        text = " > ".join(f"{value:.0f}" for value in size) + " mm"
        found.append(Trend("displacement grows towards the bit", text, size[0] >= size[1] >= size[2]))
    return found


def _sweep(results: Results, fixed: float, values: tuple[float, ...]) -> list[tuple[Case, Measured]]:
    cases = [Case(fixed, value) if values is SPEEDS else Case(value, fixed) for value in values]
    return [(case, results[case]) for case in cases if case in results]


def _values(results: Results, fixed: float, values: tuple[float, ...], name: str) -> list[tuple[float, float]]:
    pairs = []
    for case, measured in _sweep(results, fixed, values):
        place = case.speed if values is SPEEDS else case.weight_on_bit
        pairs.append((place, number_or_nan(getattr(measured, name))))
    return pairs


def _falls(pairs: list[tuple[float, float]], sense: float = 1.0) -> bool:
    """True if values decrease (increase for sense -1) within the slack, and from first to last by more than that."""
    values = [sense * y for _, y in pairs]
    if len(values) < 2 or not all(math.isfinite(value) for value in values):
        return False
    slack = [SLACK * abs(value) for value in values]
    steady = all(b <= a + s for a, b, s in zip(values, values[1:], slack, strict=False))
    return steady and values[-1] < values[0] - slack[0]


def _linear(pairs: list[tuple[float, float]]) -> Trend:
    """Near-linear: a falling straight line explains nine tenths of the variance."""
    x, y = (np.array(column) for column in zip(*pairs, strict=True)) if pairs else (np.empty(0), np.empty(0))
    if x.size < 3 or not np.isfinite(y).all():
        return Trend("critical time nearly linear in speed", "unknown", right=False)
    slope, level = np.polyfit(x, y, 1)
    spread = float(np.var(y))
    explained = 1.0 - float(np.var(y - slope * x - level)) / spread if spread > 0.0 else 0.0
    text = f"{slope:+.2f} s per rev/s, explains {explained:.0%} of the variance"
    return Trend("critical time nearly linear in speed", text, right=slope < 0.0 and explained >= 0.9)


def _flattens(statement: str, pairs: list[tuple[float, float]], unit: str) -> Trend:
    """Trend that flattens: the change from 150 to 300 N is less than a fifth of that from 20 to 150 N."""
    at = dict(pairs)
    if not all(math.isfinite(at.get(load, math.nan)) for load in (20.0, 150.0, 300.0)):
        return Trend(statement, "unknown", right=False)
    first, second = at[20.0] - at[150.0], at[150.0] - at[300.0]
    text = f"{-first:+.2f} {unit} from 20 to 150 N, {-second:+.2f} {unit} from 150 to 300 N"
    return Trend(statement, text, right=first > 0.0 and abs(second) <= 0.2 * first)


def _surge(results: Results) -> Trend:
    surge, speed = published().surge, surge_speed(results)
    text = "no rise of the ratio by 0.25 from one speed to the next" if speed is None else f"at {speed:g} rev/s"
    ours = _listed(_values(results, LOAD, SPEEDS, "ratio"), "", "{:+.2f}")
    right = speed is not None and surge.low <= speed <= surge.high
    return Trend(f"whirl over rotation surges at {surge.low:g}-{surge.high:g} rev/s", f"{text}; {ours}", right)


def _listed(pairs: list[tuple[float, float]], unit: str, form: str = "{:.2f}") -> str:
    return " ".join(form.format(y) if math.isfinite(y) else "none" for _, y in pairs) + f" {unit}".rstrip()
