# SPDX-License-Identifier: Apache-2.0
"""Score of whirl found from one sub in the middle of the string: bench runs, random runs, events, hours of noise."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from drill_twin.core.table import Table
from drill_twin.whirl import MarkInfo, Summary
from drill_twin.whirl.downhole import SubAnalyzer
from drill_twin.whirl.downhole.motion import SLOWEST
from drill_twin_evidence.detection.cases import bench, simulated
from drill_twin_evidence.detection.ground_truth import asynchronous, mark_onsets, revolutions_of
from drill_twin_evidence.detection.runs import SENSOR_RADIUS, Run
from drill_twin_evidence.detection.sub_events import EventScore, measure_events
from drill_twin_evidence.detection.sub_readings import BIAS, MARK, NOISE, analyser_of

EARLY = 12.0
"""Onsets before this are counted, not scored: there the sub does not know its mean [rev]."""
WITHIN = 1.0
"""Tolerance of an onset [rev]."""
RATE, SPEED, PART = 100.0, 2.0, 600.0
"""Samples in a second, rotation [rev/s] and length of a part [s] of the hours of noise."""


@dataclass
class SubScore:
    """Score of one sub over runs."""

    onset_error: list[float] = field(default_factory=list)
    """Found minus true onset [rev]."""
    missed: int = 0
    """Onsets that were not found."""
    slow: int = 0
    """Of these, whirls slower than the corner of the high pass."""
    false: int = 0
    """Runs without an onset in which one was found."""
    early: int = 0
    """Runs whose onset is in the first 12 revolutions, which are not scored."""
    senses: list[bool] = field(default_factory=list)
    """Correctness of the sense of the whirl, by run in which it was found."""

    def to_dict(self) -> dict[str, Any]:
        """Plain types for JSON."""
        onsets, met = len(self.onset_error) + self.missed, [abs(error) <= WITHIN for error in self.onset_error]
        return {
            "onsets": onsets, "met": sum(met) / onsets if onsets else None,
            "missed": self.missed, "slow": self.slow, "false": self.false,
            "early": self.early, "sense": float(np.mean(self.senses)) if self.senses else None,
            "median_error_rev": float(np.median(np.abs(self.onset_error))) if self.onset_error else None,
        }  # fmt: skip

    def add(self, run: Run, found: Summary) -> None:
        """Add the findings in a run."""
        true, revolutions = mark_onsets(run)[MARK], revolutions_of(run.time, run.top_speed)
        if true is None:
            self.false += found.onset is not None
            return
        began = float(np.interp(true, run.time, revolutions))
        if began < EARLY:
            self.early += 1
        elif found.onset is None:
            self.missed += 1
            self.slow += abs(_precession(run, true)) < SLOWEST
        else:
            self.onset_error.append(float(np.interp(found.onset.time_s, run.time, revolutions)) - began)
            if found.mean_ratio is not None:
                self.senses.append((found.mean_ratio > 0.0) == (_swept(run, true) > 0.0))


def measure_sub(benches: int, drawn: int, events: int, hours: float) -> dict[str, Any]:
    """Score a sub over bench runs, random runs, runs with impacts and stick-slip, and hours of noise; plain types."""
    counts, runs = {"bench": benches, "drawn": drawn}, {"bench": bench, "drawn": simulated}
    sets = {name: SubScore() for name in counts}
    for name, count in counts.items():
        for number in range(count):
            run = runs[name](number, subs=True)
            sets[name].add(run, analyser_of(run, number).summary())
    scored: EventScore = measure_events(events)
    return {
        "runs": counts,
        "sets": {name: score.to_dict() for name, score in sets.items()},
        "events": scored.to_dict(),
        "hours": hours,
        "noise_onsets": noise_onsets(hours),
    }


def markdown(plain: dict[str, Any]) -> str:
    """Tables of `measure_sub`."""
    sets, events = plain["sets"].values(), plain["events"]
    rows = [
        ("onsets after 12 revolutions", [str(one["onsets"]) for one in sets]),
        ("found within a revolution (90 % asked for)", [_share(one["met"]) for one in sets]),
        ("missed, of these slower than the corner", [f"{one['missed']}, {one['slow']}" for one in sets]),
        ("false", [str(one["false"]) for one in sets]),
        ("median error [rev]", [_number(one["median_error_rev"]) for one in sets]),
        ("sense right (95 % asked for)", [_share(one["sense"]) for one in sets]),
    ]
    error = events["largest_error"]
    of_events = [
        ("hard impacts in bouncing runs, found", f"{events['hard_impacts']}, {_share(events['hard_impacts_found'])}"),
        ("impacts found, in contact with the wall",
         f"{events['impacts_found']}, {_share(events['impacts_in_contact'])}"),
        ("runs in stick-slip, found", f"{events['stick_slip_runs']}, {events['stick_slip_found']}"),
        ("largest error of period, severity, share of time at rest",
         f"{_share(error['period'])}, {_share(error['severity'])}, {_number(error['rest'])}"),
    ]  # fmt: skip
    heads = ("one sub", *(f"{count} {name} runs" for name, count in plain["runs"].items()))
    noise = f"{plain['hours']:g} h of noise: {plain['noise_onsets']} onsets (0 asked for)."
    runs = Table(heads, ((name, *values) for name, values in rows))
    return "\n".join([
        runs.markdown(), "", Table(("events of the section", ""), of_events).markdown(), "", noise, "",
    ])  # fmt: skip


def noise_onsets(hours: float) -> int:
    """Number of hours of steady rotation with noise and bias in which an onset is found."""
    return sum(_in_noise(part, min(1.0, hours - part)) for part in range(math.ceil(hours)))


def _in_noise(part: int, hours: float) -> bool:
    """Return True if an onset is found in at most an hour of noise."""
    draw = np.random.default_rng([part, 13])
    turn = math.tau * SPEED
    steady = np.array([-SENSOR_RADIUS * turn**2, 0.0, 9.81, 0.0, 0.0, turn]) + np.repeat(BIAS, 3) * draw.normal(size=6)
    analyzer = SubAnalyzer(MarkInfo("sub", 2.5, "centre", 0.00825, 0.08175), SENSOR_RADIUS, NOISE)
    count, size = round(hours * 3600.0 * RATE), round(PART * RATE)
    for first in range(0, count, size):
        rows = np.arange(first, min(first + size, count))
        readings = steady + np.repeat(NOISE, 3) * draw.normal(size=(rows.size, 6))
        stamps = np.round((rows + 0.5) / RATE * 1e9).astype(np.int64)
        for stamp, values in zip(stamps.tolist(), readings, strict=True):
            analyzer.push(stamp, values)
    return analyzer.findings.onset is not None


def _precession(run: Run, since: float) -> float:
    """Mean whirl ratio from a time to the end of a run."""
    late = run.time >= since
    angle = np.unwrap(np.angle(run.mark_centre[late, MARK]))
    revolutions = revolutions_of(run.time, run.top_speed)[late]
    return float((angle[-1] - angle[0]) / math.tau / (revolutions[-1] - revolutions[0]))


def _swept(run: Run, since: float) -> float:
    """Area that the asynchronous part has swept since a time, positive in the sense of rotation."""
    revolutions = revolutions_of(run.time, run.top_speed)
    part = asynchronous(run.mark_centre[:, [MARK]], run.mark_spin[:, [MARK]], revolutions)[run.time >= since, 0]
    return float((part[:-1].conj() * np.diff(part)).imag.sum() * np.sign(run.top_speed[-1]))


def _share(value: float | None) -> str:
    return "-" if value is None else f"{100.0 * value:.1f} %"


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.2f}"
