# SPDX-License-Identifier: Apache-2.0
"""Freshness of the sources of the live page: the nodes that send, and how long ago each was heard."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from drill_twin.io.messages.diagnostics import Level, Status
from drill_twin.io.messages.good_samples import GONE, STALE, GoodSamples
from drill_twin.io.messages.topics import (
    ADVICE_STATE,
    ESTIMATE_STATE,
    MARKS_STATE,
    RIG_STATE,
    STRING_POSES,
    WHIRL_STATE,
)
from drill_twin_dashboard.live.shown import short

_STREAMS = {
    **dict.fromkeys((STRING_POSES, MARKS_STATE, RIG_STATE), "simulator"),
    WHIRL_STATE: "analyzer",
    ADVICE_STATE: "advisor",
    ESTIMATE_STATE: "estimator",
}
_LATE = 0.6  # s; diagnostics come once a second, so one that is younger than a stale value and this is not late
_FORGOTTEN = 60.0  # s
_MOST_NODES, _LONGEST_NAME, _LONGEST_TEXT = 200, 100, 1000


@dataclass
class _Report:
    status: Status
    time: float


class Sources:
    """Times of the last messages of simulator and analyzer, and of the diagnostics of every node."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._samples = GoodSamples(clock)
        self._reports: dict[str, _Report] = {}

    def message(self, topic: str, *, finite: bool = True) -> None:
        """Note a message on a topic, that could be read; one without a finite number tells nothing."""
        if source := _STREAMS.get(topic):
            self._samples.take(source, finite=finite)

    def report(self, status: Status) -> None:
        """Note the diagnostics of a node; those of a node that ends in order are its last."""
        if "ended" in status.values:
            self._reports.pop(status.name, None)
        else:
            name, text = short(status.name, _LONGEST_NAME), short(status.text, _LONGEST_TEXT)
            values = {key: value for key, value in status.values.items() if key == "state"}
            self._reports.pop(name, None)
            self._reports[name] = _Report(replace(status, name=name, text=text, values=values), self._clock())
            if len(self._reports) > _MOST_NODES:
                del self._reports[next(iter(self._reports))]  # the one not heard for longest

    def age(self, source: str) -> float | None:
        """Age of the values of `simulator` or `analyzer` [s]; None before the first.

        While time stands still by intention, no frames come, and diagnostics show that the node is alive.
        """
        stream, now = self._samples.age(source), self._clock()
        if math.isinf(stream):
            return None
        simulator, own = self._report("simulator"), self._report(source)
        if simulator and own and simulator.status.values.get("state", "running") != "running":
            stands_still = now - simulator.time < STALE + _LATE
            return min(stream, max(now - own.time - _LATE, 0.0)) if stands_still else stream
        return stream

    def _report(self, node: str) -> _Report | None:
        return next((report for name, report in self._reports.items() if name.rpartition("/")[2] == node), None)

    def nodes(self) -> list[dict[str, Any]]:
        """Name, level, text and age [s] of each node, for JSON; a node not heard for a minute is left out."""
        now = self._clock()
        rows = []
        for name, report in sorted(self._reports.items()):
            age, level, text = now - report.time, report.status.level, report.status.text
            if age > STALE + _LATE:
                level, text = Level.STALE if age <= GONE else Level.ERROR, f"no diagnostics for {age:.0f} s"
            if age < _FORGOTTEN:
                rows.append({"name": name, "level": int(level), "text": text, "age": age})
        return rows

    def missing(self) -> list[str]:
        """Names of the nodes that have not been heard for longer than values last, and did not end in order."""
        return [row["name"] for row in self.nodes() if row["age"] > GONE]


_INSTEAD: dict[str, tuple[str, Callable[[str], dict[str, Any]], tuple[str, ...]]] = {
    "simulator": (
        "data of the simulator",
        lambda text: {"time": None, "nodes": [], "trail": {}, "rig": {}, "simulator": {"factor": "", "text": text}},
        ("x", "y", "z"),
    ),
    "analyzer": (
        "findings of the analyzer",
        lambda text: {"motion": {"state": "", "criterion": text, "whirls": False}, "onset": None},
        ("orbit", "precession", "motion"),
    ),
    "advisor": ("advice", lambda text: {"advice": {"text": text, "level": int(Level.STALE)}}, ()),
    "estimator": ("estimates", lambda text: {"estimates": {"level": int(Level.STALE), "text": text, "rows": []}}, ()),
}
"""By source: its values in words, the picture once they are gone, with a sentence, and its values of each mark."""


def without_old_values(picture: dict[str, Any], sources: Sources, starting: str) -> dict[str, Any]:
    """Add the ages of the sources, and take away what is gone; a simulator that is `starting` has no frames as yet."""
    ages = {source: sources.age(source) for source in _INSTEAD}
    picture |= {"ages": ages, "graph": sources.nodes()}
    for source, (words, instead, of_marks) in _INSTEAD.items():
        if (age := ages[source]) is not None and age > GONE:
            picture |= instead(f"no {words} for {age:.0f} s")
            picture["marks"] = [
                {key: value for key, value in mark.items() if key not in of_marks} for mark in picture["marks"]
            ]
    if starting:
        text = next((row["text"] for row in picture["graph"] if row["name"] == starting), "the simulator has ended")
        picture["simulator"] = {"factor": "", "text": text}
    return picture
