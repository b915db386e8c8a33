# SPDX-License-Identifier: Apache-2.0
"""Score of whirl found from one sub: bench runs with a sub in the middle of the string, and hours of noise."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from drill_twin.studies.detection.cases import bench_with_subs
from drill_twin.studies.detection.ground_truth import asynchronous, revolutions_of, truth_of
from drill_twin.studies.detection.runs import SENSOR_RADIUS, Run
from drill_twin.studies.detection.scoring import EARLY
from drill_twin.whirl import MarkInfo, Summary
from drill_twin.whirl.downhole import ToolNoise, analyse_sub

NOISE = ToolNoise(0.005, 0.001)
"""Noise of the sub: accelerometers [m/s^2], gyroscopes [rad/s]."""
BIAS = ToolNoise(0.05, 0.005)
"""Standard deviation of the bias on each axis."""
MARK = 2
"""Mark at whose section the sub is: the middle of the string."""
WITHIN = 1.0
"""Tolerance of an onset [rev]."""
RATE, SPEED, HOUR = 100.0, 2.0, 3600.0
"""Samples in a second, rotation [rev/s] and length of a part [s] of the hours of noise."""


@dataclass
class SubScore:
    """Score of one sub over runs."""

    onset_error: list[float] = field(default_factory=list)
    """Found minus true onset [rev]."""
    missed: int = 0
    """Onsets that were not found."""
    false: int = 0
    """Runs without an onset in which one was found."""
    early: int = 0
    """Runs whose onset is in the first 12 revolutions, which are not scored."""
    senses: list[bool] = field(default_factory=list)
    """Whether the sense of the whirl is right, by run in which it was found."""
    noise_onsets: int = 0
    """Onsets in the hours of noise."""

    def to_dict(self) -> dict[str, Any]:
        """Plain types for JSON."""
        onsets = len(self.onset_error) + self.missed
        met = sum(abs(error) <= WITHIN for error in self.onset_error)
        return {
            "onsets": onsets, "met": met / onsets if onsets else None, "missed": self.missed, "false": self.false,
            "early": self.early, "sense": float(np.mean(self.senses)) if self.senses else None,
            "median_error_rev": float(np.median(np.abs(self.onset_error))) if self.onset_error else None,
            "noise_onsets": self.noise_onsets,
        }  # fmt: skip


def measure_sub(runs: int, hours: float) -> SubScore:
    """Score a sub over bench runs and hours of steady rotation with noise."""
    score = SubScore()
    for number in range(runs):
        run = bench_with_subs(number)
        _add(score, run, _found(run, number))
    for part in range(math.ceil(hours * 3600.0 / HOUR)):
        score.noise_onsets += _in_noise(part) is not None
    return score


def markdown(plain: dict[str, Any], runs: int, hours: float) -> str:
    """Table of a score in plain types."""
    met, sense = ("-" if plain[key] is None else f"{100.0 * plain[key]:.1f} %" for key in ("met", "sense"))
    error = "-" if plain["median_error_rev"] is None else f"{plain['median_error_rev']:.2f}"
    return (
        f"| {runs} bench runs, one sub | found |\n| --- | --- |\n"
        f"| onsets after 12 revolutions | {plain['onsets']} |\n"
        f"| found within a revolution | {met} (90 % asked for) |\n"
        f"| missed, false | {plain['missed']}, {plain['false']} |\n"
        f"| median error [rev] | {error} |\n"
        f"| sense right | {sense} (95 % asked for) |\n"
        f"| onsets in {hours:g} h of noise | {plain['noise_onsets']} (0 asked for) |\n"
    )


def _found(run: Run, seed: int) -> Summary:
    if run.readings is None:
        raise ValueError("expected a run with the readings of subs")
    draw = np.random.default_rng([seed, 12])
    readings = run.readings[:, MARK] + np.repeat(NOISE, 3) * draw.normal(size=(run.time.size, 6))
    readings += np.repeat(BIAS, 3) * draw.normal(size=6)
    middle = run.time - 0.5 * (run.time[1] - run.time[0])
    mark = replace(run.marks[MARK], on="centre")
    return analyse_sub(np.round(middle * 1e9).astype(np.int64), readings, mark, SENSOR_RADIUS, NOISE)


def _add(score: SubScore, run: Run, found: Summary) -> None:
    true, revolutions = truth_of(run).mark_onset[MARK], revolutions_of(run.time, run.top_speed)
    if true is None:
        score.false += found.onset is not None
        return
    began = float(np.interp(true, run.time, revolutions))
    if began < EARLY:
        score.early += 1
    elif found.onset_s is None:
        score.missed += 1
    else:
        score.onset_error.append(float(np.interp(found.onset_s, run.time, revolutions)) - began)
        if found.mode_ratio is not None:
            score.senses.append((found.mode_ratio > 0.0) == (_swept(run, true) > 0.0))


def _swept(run: Run, since: float) -> float:
    """Area that the asynchronous part has swept since a time, positive in the sense of rotation."""
    revolutions = revolutions_of(run.time, run.top_speed)
    part = asynchronous(run.mark_centre[:, [MARK]], run.mark_spin[:, [MARK]], revolutions)[run.time >= since, 0]
    return float((part[:-1].conj() * np.diff(part)).imag.sum() * np.sign(run.top_speed[-1]))


def _in_noise(part: int) -> float | None:
    """Onset found in an hour of steady rotation with noise and bias [s]."""
    draw = np.random.default_rng([part, 13])
    count = round(HOUR * RATE)
    turn = math.tau * SPEED
    readings = np.repeat(NOISE, 3) * draw.normal(size=(count, 6)) + np.repeat(BIAS, 3) * draw.normal(size=6)
    readings += np.array([-SENSOR_RADIUS * turn**2, 0.0, 9.81, 0.0, 0.0, turn])
    mark = MarkInfo("sub", 2.5, "centre", 0.00825, 0.08175)
    stamp = np.round((np.arange(count) + 0.5) / RATE * 1e9).astype(np.int64)
    return analyse_sub(stamp, readings, mark, SENSOR_RADIUS, NOISE).onset_s
