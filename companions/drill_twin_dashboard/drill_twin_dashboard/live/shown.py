# SPDX-License-Identifier: Apache-2.0
"""Values, scene, advice, map and estimates on the live page, from messages of unknown origin, and their freshness.

The sources of a running twin are the nodes that send. Values of a source that has not been heard for `GONE` are taken
away, and a sentence says so.
"""

import math
import time
from collections.abc import Callable
from dataclasses import replace
from string import hexdigits
from typing import Any

from drill_twin.core.errors import MessageError, printable
from drill_twin.core.files.json_files import read_json
from drill_twin.core.severity import whose_bounds
from drill_twin.core.units.system import QUANTITIES
from drill_twin.dynamics.twin.frame import RigState
from drill_twin.io.messages.decode import JointState
from drill_twin.io.messages.diagnostics import Level, Status
from drill_twin.io.messages.good_samples import GONE, STALE, GoodSamples
from drill_twin.io.messages.topic_words import REGIME_COLOURS, SENSORS, AdviceCode
from drill_twin.io.messages.topics import (
    ADVICE_STATE,
    ESTIMATE_STATE,
    MARKS_STATE,
    RIG_STATE,
    STRING_POSES,
    WHIRL_STATE,
)
from drill_twin.io.scene_geometry import string_steps
from drill_twin.report.string_curve import well_geometry
from drill_twin.scene import Scene

SHOWN_STEPS = 64
"""Steps of the map along each range on the page; a finer one is shown at every second node, or fewer."""
_MOST_STEPS = 1024


def short(text: str, most: int = 300) -> str:
    """Text of bounded length, without control characters."""
    return printable(text[:most], keep="")


def number(value: float) -> float | None:
    """Number for JSON, which has no NaN."""
    return float(value) if math.isfinite(value) else None


def rig_values(state: RigState) -> dict[str, float]:
    """Values of the rig by name [N, rev/s, N m, m/s]; no rate of penetration where the bit has not drilled."""
    return {
        "wob": state.bit_force,
        "rps": state.top_drive_speed / math.tau,
        "torque": state.top_drive_torque,
        "bit_rps": state.bit_speed / math.tau,
        "bit_torque": state.bit_torque,
        "hookload": state.hookload,
        "rop": state.rate_of_penetration if state.drilled > 0.0 else math.nan,
    }


def shown_advice(state: JointState) -> dict[str, Any]:
    """Level of a `/advice/state`, and the set-point that is advised, `wob` [N] and `rps` [rev/s], if there is one.

    Raises:
        MessageError: The message has no advice.
    """
    values = dict(zip(state.names, state.position.tolist(), strict=False))
    if "advice" not in values:
        raise MessageError(f"expected the code of an advice, found {', '.join(state.names) or 'none'}")
    level = {AdviceCode.NEAR: Level.WARN, AdviceCode.LEAVE: Level.ERROR}.get(values["advice"], Level.OK)
    shown: dict[str, Any] = {"level": int(level)}
    target = [values.get(f"target/{name}", math.nan) for name in ("weight_on_bit", "rotation")]
    if values.get("target") and all(map(math.isfinite, target)):
        shown |= {"wob": target[0], "rps": target[1] / math.tau}
    return shown


def shown_map(text: str) -> dict[str, Any]:
    """Ranges in N and rev/s, and a hexadecimal digit a node for regime, whirl from rest and whirl that goes on.

    Raises:
        MessageError: The message is no map of `/advice/map`.
    """
    data = read_json(text, largest=4 * (_MOST_STEPS + 1) ** 2)
    try:
        steps = int(data["steps"])
        (low, high), (slow, fast) = (map(float, data[name]) for name in ("weight_on_bit_N", "rotation_rad_s"))
        every, side = max(1, steps // SHOWN_STEPS), steps + 1
        fields = {name: str(data[name]) for name in ("codes", "whirls", "keeps")}
        names, digest, window = list(data["regimes"]), str(data["digest"]), data["safe_window"]
        edges = [low, high, slow, fast, *map(float, window or ())]
        good = 1 <= steps <= _MOST_STEPS and low < high and slow < fast and all(map(math.isfinite, edges))
        if not (good and all(len(digits) == side**2 and set(digits) <= set(hexdigits) for digits in fields.values())):
            raise ValueError
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        raise MessageError("expected an operating map, found another text") from error
    rows = range(0, side, every)
    return {
        "digest": digest[:64],
        "colours": REGIME_COLOURS,
        "wob": [low, high],
        "rps": [slow / math.tau, fast / math.tau],
        "regimes": [short(str(name), 40) for name in names[:16]],
        "window": edges[4:6] + [edge / math.tau for edge in edges[6:]],
        **{name: "".join(digits[i * side + j] for i in rows for j in rows) for name, digits in fields.items()},
    }


_MOST, _ROW_NAME = 50, 60  # rows of estimates; characters of a row's name
_ENDS = ("/low", "/high")
_LIKELY = 0.5
"""Chance of whirl from which the page warns."""


def shown_estimates(state: JointState) -> dict[str, Any]:
    """Levels of a `/estimate/state`, and rows of it for the page.

    A row has name, mean, low and high end of its 90 % band. A row with a unit has its quantity too, and values in the
    page's own unit, which the page shows in the reader's unit. `trust` is the level of the trust in the estimates; an
    unusable estimate has no row.

    Raises:
        MessageError: The message has neither trust nor alarm.
    """
    values = dict(zip(state.names, state.position.tolist(), strict=False))
    if not {"trust", "alarm"} <= values.keys():
        raise MessageError(f"expected trust and alarm among the estimates, found {', '.join(state.names) or 'none'}")
    trust = Level.OK if values["trust"] == 0.0 else Level.WARN if values["trust"] == 1.0 else Level.ERROR
    chance = values.get("chance_of_whirl", math.nan)
    level = Level.ERROR if values["alarm"] else max(trust, Level.WARN if chance >= _LIKELY else Level.OK)
    named = [name for name in values if all(name + end in values for end in _ENDS)]
    rows = [{"name": "chance of whirl", "mean": number(chance), "low": None, "high": None}]
    rows += [_row(name, values) for name in named[:_MOST]]
    return {"level": int(level), "trust": int(trust), "rows": [] if trust is Level.ERROR else rows}


def _row(name: str, values: dict[str, float]) -> dict[str, Any]:
    unit = "m" if name.endswith(("/x", "/y")) else SENSORS.get(name, "")
    quantity = "offset" if unit == "m" else QUANTITIES.get(unit, "")  # radii and places across the hole
    factor = 1.0 / math.tau if quantity == "rotation" else 1.0  # to the page's own unit
    mean, low, high = (number(factor * values[name + end]) for end in ("", *_ENDS))
    shown = short(name, _ROW_NAME)
    band = {"mean": mean, "low": low, "high": high}
    return {"name": shown.replace("_", " "), "quantity": quantity, **band} if quantity else {"name": shown, **band}


_STATIONS = 41  # depths at which the hole is drawn, and at each change of its radius


def shown_scene(scene: Scene) -> dict[str, Any]:
    """Well, string, walls and clearances [m] by mark, set-points [N, rev/s] of a scene, as plain types for JSON."""
    marks = scene.string.marks
    return {
        "name": scene.name,
        "units": scene.unit_system.name,
        "bounds": whose_bounds(scene.severity.whose if scene.severity else None, scene.unit_system.name),
        "length": scene.length,
        "well": well_geometry(scene, _STATIONS),
        "string": string_steps(scene),
        "walls": {mark.name: scene.hole.radius_at(scene.length - mark.distance_from_bit) for mark in marks},
        "clearance": {mark.name: scene.clearance_at(mark.distance_from_bit) for mark in marks},
        "wob": scene.rig.weight_on_bit.value,
        "rps": scene.rig.rotation.value / math.tau,
    }


_STREAMS = {
    **dict.fromkeys((STRING_POSES, MARKS_STATE, RIG_STATE), "simulator"),
    WHIRL_STATE: "analyzer",
    ADVICE_STATE: "advisor",
    ESTIMATE_STATE: "estimator",
}
_LATE = 0.6
"""Time beyond `STALE` after which the diagnostics of a node are late [s]: they come once a second."""
_FORGOTTEN = 60.0
"""Time after which a silent node is left out of the table [s]."""
_MOST_NODES, _NODE_NAME, _NODE_TEXT = 200, 100, 1000  # nodes; characters


class Sources:
    """Times of the last messages of simulator and analyzer, and of the diagnostics of every node."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._samples = GoodSamples(clock)
        self._reports: dict[str, tuple[Status, float]] = {}  # by node, with the time at which they came

    def message(self, topic: str, *, finite: bool = True) -> None:
        """Note a message on a topic that could be read; a message without a finite number tells nothing."""
        if source := _STREAMS.get(topic):
            self._samples.take(source, finite=finite)

    def report(self, status: Status) -> None:
        """Note the diagnostics of a node, and forget a node that says that it ended."""
        if "ended" in status.values:
            self._reports.pop(status.name, None)
        else:
            name, text = short(status.name, _NODE_NAME), short(status.text, _NODE_TEXT)
            values = {key: value for key, value in status.values.items() if key == "state"}
            self._reports.pop(name, None)
            self._reports[name] = replace(status, name=name, text=text, values=values), self._clock()
            if len(self._reports) > _MOST_NODES:
                del self._reports[next(iter(self._reports))]  # the one not heard for longest

    def age(self, source: str) -> float | None:
        """Age of the values of `simulator` or `analyzer` [s]; None before the first.

        While time stands still by intention, no frames come, and diagnostics show that the node is alive.
        """
        stream, now = self._samples.age(source), self._clock()
        if math.isinf(stream):
            return None
        simulator, own = self._report("simulator") or self._report("replayer"), self._report(source)
        if simulator and own and simulator[0].values.get("state", "running") != "running":
            stands_still = now - simulator[1] < STALE + _LATE
            return min(stream, max(now - own[1] - _LATE, 0.0)) if stands_still else stream
        return stream

    def _report(self, node: str) -> tuple[Status, float] | None:
        return next((report for name, report in self._reports.items() if name.rpartition("/")[2] == node), None)

    def nodes(self) -> list[dict[str, Any]]:
        """Name, level, text and age [s] of each node, for JSON; a node not heard for a minute is left out."""
        now = self._clock()
        rows = []
        for name, (status, time_heard) in sorted(self._reports.items()):
            age, level, text = now - time_heard, status.level, status.text
            if age > STALE + _LATE:
                level, text = Level.STALE if age <= GONE else Level.ERROR, f"no diagnostics for {age:.0f} s"
            if age < _FORGOTTEN:
                rows.append({"name": name, "level": int(level), "text": text, "age": age})
        return rows


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
"""For each source: words for its values; what the page shows, with a sentence, once the values are gone; and the names
of its values of a mark."""


def without_old_values(picture: dict[str, Any], sources: Sources, starting: str) -> dict[str, Any]:
    """Add the ages of the sources, and take away the values of sources that are gone.

    Args:
        picture: State of the page.
        sources: The sources.
        starting: Name of a simulator that has no frames as yet; empty: none.
    """
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
