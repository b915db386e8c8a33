# SPDX-License-Identifier: Apache-2.0
"""Score of impacts and stick-slip found by one sub, against contacts and spin of its section in the full state."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np

from drill_twin.core.arrays import Array, Mask
from drill_twin.scene import load_scene
from drill_twin.whirl.criteria import STANDSTILL
from drill_twin.whirl.downhole.sub_findings import SHARE
from drill_twin_evidence.detection.cases import bouncing
from drill_twin_evidence.detection.runs import Run, simulate
from drill_twin_evidence.detection.sub_readings import MARK, analyser_of

FAST = {
    "numerics.frame_rate": "1 kHz",
    "rig.weight_on_bit.start": "1 s",
    "rig.weight_on_bit.duration": "2 s",
    "rig.duration": "10 s",
}
"""Changes of a bouncing run, so that frames and readings resolve its contacts."""
WEIGHTS = ("52 kN", "53 kN", "54 kN", "55 kN", "56 kN")
"""Weights on bit of the runs in stick-slip."""
NEAR = 0.02
"""An impact is that of a contact within this time [s]."""
SETTLED = 60.0
"""Time until stick-slip is periodic [s]."""


@dataclass
class EventScore:
    """Score of impacts and stick-slip."""

    hard: int = 0
    """True impacts: contacts that the section approaches faster than the share of clearance and rotation asked for."""
    hard_found: int = 0
    """Those near which an impact was found."""
    found: int = 0
    """Impacts found."""
    in_contact: int = 0
    """Those near which the section touches the wall."""
    stick_slip: int = 0
    """Runs in stick-slip."""
    period_error: list[float] = field(default_factory=list)
    severity_error: list[float] = field(default_factory=list)
    rest_error: list[float] = field(default_factory=list)
    """Found less true period over the period, severity, and share of the time at rest, by run in which it was found."""

    def to_dict(self) -> dict[str, Any]:
        """Plain types for JSON."""
        largest = {
            name: max(map(abs, getattr(self, f"{name}_error")), default=None) for name in ("period", "severity", "rest")
        }
        return {
            "hard_impacts": self.hard, "hard_impacts_found": self.hard_found / self.hard if self.hard else None,
            "impacts_found": self.found, "impacts_in_contact": self.in_contact / self.found if self.found else None,
            "stick_slip_runs": self.stick_slip, "stick_slip_found": len(self.period_error), "largest_error": largest,
        }  # fmt: skip


def measure_events(runs: int) -> EventScore:
    """Score impacts in bouncing runs and stick-slip of the two-mass model, at most so many of each."""
    score = EventScore()
    for seed in range(runs):
        add_impacts(score, bouncing(seed, FAST, subs=True), seed)
    for seed, weight in enumerate(WEIGHTS[:runs]):
        add_stick_slip(score, _sticking(weight), seed)
    return score


def add_impacts(score: EventScore, run: Run, seed: int) -> None:
    """Compare the impacts that a sub finds with the contacts of its section."""
    found = np.array(analyser_of(run, seed).motion.impacts.times)
    touching = run.mark_force[:, MARK] > 0.0
    distance = np.abs(run.mark_centre[:, MARK])
    first = np.flatnonzero(touching[2:] & ~touching[1:-1]) + 2
    speed = (distance[first - 1] - distance[first - 2]) / (run.time[1] - run.time[0])
    least = SHARE * run.marks[MARK].clearance * np.abs(run.top_speed[first])
    hard, contact = run.time[first[speed > least]], run.time[touching]
    score.hard += hard.size
    score.hard_found += int(_near(hard, found).sum())
    score.found += found.size
    score.in_contact += int(_near(found, contact).sum())


def add_stick_slip(score: EventScore, run: Run, seed: int) -> None:
    """Compare the last stick-slip that a sub finds with the spin of its section over the same time."""
    found = analyser_of(run, seed, mark=0).summary()
    last = found.stick_slip[-1] if found.stick_slip else None
    during = (run.time > SETTLED) if last is None else (run.time >= last.start_s) & (run.time <= last.end_s)
    speed, time = np.gradient(run.mark_spin[:, 0], run.time)[during], run.time[during]
    rest = speed < STANDSTILL * float(speed.mean())
    release = np.flatnonzero(rest[:-1] & ~rest[1:])
    if release.size < 2:
        return
    score.stick_slip += 1
    if last is None or found.sub is None or found.sub.share_at_rest is None:
        return
    cycles = [speed[first:end] for first, end in pairwise(release.tolist())]
    severity = float(np.mean([np.ptp(cycle) / (2.0 * cycle.mean()) for cycle in cycles]))
    score.period_error.append(last.period_s / float(np.diff(time[release]).mean()) - 1.0)
    score.severity_error.append(last.severity / severity - 1.0)
    score.rest_error.append(found.sub.share_at_rest - float(rest[release[0] : release[-1]].mean()))


def _near(times: Array, others: Array) -> Mask:
    """Return True for each time that is near one of the others, in order."""
    if not others.size:
        return np.zeros(times.size, bool)
    after = np.searchsorted(others, times)
    gaps = [np.abs(others[np.clip(after + k, 0, others.size - 1)] - times) for k in (-1, 0)]
    found: Mask = np.minimum(*gaps) <= NEAR
    return found


def _sticking(weight: str) -> Run:
    """The two-mass model in stick-slip, with a sub at the bit."""
    changes = {
        "rig.weight_on_bit.value": weight,
        "rig.duration": "120 s",
        "string.marks": "[{name: bit, distance_from_bit: 0 mm, on: centre}]",
    }
    return simulate(f"two_mass: {weight}", changes, subs=True, scene_text=load_scene("two_mass").to_yaml())
