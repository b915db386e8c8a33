# SPDX-License-Identifier: Apache-2.0
"""State of the live page: the latest values of the topics, of a running twin or of a bag."""

from __future__ import annotations

import math
import threading
from collections.abc import Iterable, Mapping
from contextlib import suppress
from typing import Any

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.errors import DrillTwinError, MessageError, printable
from drill_twin.dynamics.twin.frame import RigState
from drill_twin.io.bag.skipped import SkippedMessages
from drill_twin.io.findings_encoder import BIT
from drill_twin.io.messages.decode import JointStateReader, read_pose_array, read_string
from drill_twin.io.messages.diagnostics import Level, decode_diagnostics
from drill_twin.io.messages.encode import MARK_AXES
from drill_twin.io.messages.good_samples import GONE
from drill_twin.io.messages.rig_messages import read_rig_state
from drill_twin.io.messages.stamps import seconds
from drill_twin.io.messages.topics import (
    ADVICE_MAP,
    ADVICE_STATE,
    DIAGNOSTICS,
    ESTIMATE_STATE,
    MARKS_STATE,
    RIG_STATE,
    STRING_POSES,
    TWIN_SCENE,
    WHIRL_MOTION,
    WHIRL_ONSET,
    WHIRL_STATE,
)
from drill_twin.io.messages.whirl_encode import STRING_LEVEL, decode_motion, decode_onset, read_whirl_state
from drill_twin.io.scene_geometry import string_steps
from drill_twin.live.advice import shown_map, targets
from drill_twin.live.estimates import shown_estimates
from drill_twin.live.sources import Sources
from drill_twin.live.supervision import Supervision
from drill_twin.report.page.well_geometry import well_geometry
from drill_twin.report.quantities.loads import string_weight
from drill_twin.report.string_curve import along_hole
from drill_twin.scene import Scene, parse_scene
from drill_twin.studies.maps.operating_map import digest_of

INPUTS = (
    TWIN_SCENE,
    STRING_POSES,
    MARKS_STATE,
    RIG_STATE,
    WHIRL_STATE,
    WHIRL_MOTION,
    WHIRL_ONSET,
    ADVICE_STATE,
    ADVICE_MAP,
    ESTIMATE_STATE,
    DIAGNOSTICS,
)
"""Topics that the page shows."""
_TRAIL = 400  # most positions of a mark between two snapshots
_STATIONS = 41  # depths at which the hole is drawn, and at each change of its radius
_LARGEST = 1e6  # m
_MOST_MARKS, _MOST_NODES = 200, 20_000
_LONGEST_TEXT = 300
_RATE = "rate_of_penetration_m_h"


class PageState:
    """Latest values of the topics; `update` and `snapshot` may be called from different threads."""

    def __init__(self, sources: Sources | None = None) -> None:
        """Start empty.

        Args:
            sources: Freshness of the sources of a running twin, whose values disappear when they are old; None for a
                recording, whose values stay.
        """
        self._sources = sources
        self._lock = threading.Lock()
        self._supervision = Supervision(recorded=sources is None)
        self._state = ""  # of the simulator, which another scene does not change
        self._marks_reader, self._rig_reader, self._whirl_reader = (JointStateReader().read for _ in range(3))
        self.skipped = SkippedMessages()
        """Messages that could not be used."""
        self._clear()

    def clear(self) -> None:
        """Drop all values, for a new run or another time of the recording."""
        with self._lock:
            self._clear()

    def _clear(self) -> None:
        self._time = 0.0
        self._scene: dict[str, Any] | None = None
        self._hole: Scene | None = None
        self._weight = math.nan
        self._nodes: list[list[float]] = []
        self._marks: dict[str, dict[str, Any]] = {}
        self._trail: dict[str, list[list[float]]] = {}
        self._rig: dict[str, float] = {}
        self._motion = {"state": "", "criterion": ""}
        self._onset: dict[str, Any] | None = None
        self._advice = {"text": "", "level": 0}
        self._map: dict[str, Any] | None = None
        self._estimates: dict[str, Any] | None = None
        self._simulator = {"factor": "", "text": ""}
        self._rate = math.nan
        self._starting = ""  # name of the simulator while it compiles or is not configured

    def update(self, topic: str, raw: bytes) -> None:
        """Decode a message; one that cannot be used is skipped and counted."""
        try:
            with self._lock:
                self._update(topic, raw)
                if self._sources is not None:
                    empty = topic == RIG_STATE and not any(map(math.isfinite, self._rig.values()))
                    self._sources.message(topic, finite=not empty)
        except DrillTwinError as error:
            self.skipped.add(topic, self._time, error)

    def _update(self, topic: str, raw: bytes) -> None:
        if topic == STRING_POSES:
            poses = read_pose_array(raw)
            _check_positions(poses.position)
            self._time = seconds(poses.stamp)
            nodes = poses.position
            if len(nodes) > _MOST_NODES:
                raise MessageError(f"expected at most {_MOST_NODES} positions, found {len(nodes)}")
            if self._hole is not None:
                nodes = along_hole(self._hole, nodes[None])[0]
            self._nodes = nodes.round(6).tolist()
        elif topic == MARKS_STATE:
            self._on_marks(raw)
        elif topic == RIG_STATE:
            state = self._rig_reader(raw)
            rig = read_rig_state(state)
            drag = rig.hookload + rig.bit_force - self._weight
            self._rig = {**_rig(rig), "drag": drag, "rop": self._rate}
            self._supervision.rig(seconds(state.stamp), self._rig)
        elif topic == WHIRL_STATE:
            whirl = read_whirl_state(self._whirl_reader(raw))
            for name, radius, precession in zip(whirl.marks, whirl.orbit_radius, whirl.precession, strict=True):
                self._mark(name).update(orbit=_number(radius), precession=_number(precession))
        elif topic == WHIRL_MOTION:
            self._on_motion(raw)
        elif topic == WHIRL_ONSET:
            onset = decode_onset(raw)[1]
            self._onset = None if onset is None else {"time": _number(onset.time), "mark": _short(onset.mark)}
        elif topic == ADVICE_STATE:
            for status in decode_diagnostics(raw)[1][:1]:
                self._advice = {"text": _short(status.text), "level": int(status.level), **targets(status.values)}
        elif topic == ADVICE_MAP:
            self._map = shown_map(read_string(raw))
        elif topic == ESTIMATE_STATE:
            self._estimates = shown_estimates(raw)
            self._supervision.estimate(self._estimates["level"], self._estimates["text"])
        elif topic == DIAGNOSTICS:
            self._on_diagnostics(raw)
        elif topic == TWIN_SCENE:
            self._on_scene(raw)

    def _on_motion(self, raw: bytes) -> None:
        for motion in decode_motion(raw)[1]:
            if motion.subject == STRING_LEVEL:
                self._motion = {"state": _short(motion.state), "criterion": _short(motion.criterion)}
            elif motion.subject != BIT:
                self._mark(motion.subject)["motion"] = _short(motion.state)
        upright = self._scene is not None and not self._scene["well"]["deviated"]
        clearances = self._scene["clearance"] if self._scene and upright else {}
        radii = ((mark.get("orbit"), clearances.get(name)) for name, mark in self._marks.items())
        shares = [radius / clearance for radius, clearance in radii if radius is not None and clearance]
        self._supervision.motion(self._motion["state"], max(shares, default=math.nan))

    def _mark(self, name: str) -> dict[str, Any]:
        if name not in self._marks and len(self._marks) >= _MOST_MARKS:
            raise MessageError(f"expected at most {_MOST_MARKS} marks, found another")
        return self._marks.setdefault(name, {"name": _short(name)})

    def _on_marks(self, raw: bytes) -> None:
        state = self._marks_reader(raw)
        if state.position.size != len(state.names) or state.position.size % len(MARK_AXES):
            raise MessageError(f"expected {len(MARK_AXES)} values a mark on {MARKS_STATE}, found {state.position.size}")
        positions = state.position.reshape(-1, len(MARK_AXES))
        _check_positions(positions)
        for k, (x, y, z) in enumerate(positions[:, :3].tolist()):
            name = state.names[k * len(MARK_AXES)].rpartition("/")[0]
            self._mark(name).update(x=x, y=y, z=z)
            trail = self._trail.setdefault(name, [])
            trail.append([round(x, 6), round(y, 6)])
            del trail[:-_TRAIL]

    def _on_scene(self, raw: bytes) -> None:
        scene, found = parse_scene(read_string(raw), name=TWIN_SCENE), self._map
        self._clear()
        if found is not None and found["digest"] == digest_of(scene):  # it may come before its scene
            self._map = found
        self._hole = scene if scene.hole.survey else None
        self._weight = string_weight(scene)
        self._supervision.begin(scene.name)
        marks = scene.string.marks
        self._scene = {
            "name": scene.name,
            "length": scene.length,
            "hole": scene.hole.radius,
            "well": well_geometry(scene, _STATIONS),
            "string": string_steps(scene),
            "walls": {mark.name: scene.hole.radius_at(scene.length - mark.distance_from_bit) for mark in marks},
            "clearance": {mark.name: scene.clearance_at(mark.distance_from_bit) for mark in marks},
            "wob": scene.rig.weight_on_bit.value,
            "rps": scene.rig.rotation.value / math.tau,
        }

    def _on_diagnostics(self, raw: bytes) -> None:
        for status in decode_diagnostics(raw)[1]:
            if self._sources is not None:
                self._sources.report(status)
            if (rate := status.values.get(_RATE)) is not None:
                self._rate = _rate(rate)
            if "compiling" in status.values:
                self._starting = status.name
                self._simulator = {"factor": "", "text": status.text}
            if "realtime_factor" in status.values:
                values, self._starting = status.values, ""
                self._state = _short(values.get("state", ""))
                self._simulator = {
                    "factor": _short(values.get("realtime_factor_last_second", values["realtime_factor"])),
                    "text": _short(values.get("pace", "") if status.level == Level.OK else status.text),
                }

    def snapshot(self) -> dict[str, Any]:
        """All values as plain types for JSON, with the positions of the marks since the last snapshot."""
        with self._lock:
            trail, self._trail = self._trail, {}
            picture = {
                "time": self._time,
                "scene": self._scene,
                "nodes": self._nodes,
                "marks": [dict(mark) for mark in self._marks.values()],
                "trail": trail,
                "rig": {name: _number(value) for name, value in self._rig.items()},
                "motion": self._motion,
                "onset": self._onset,
                "advice": self._advice,
                "map": self._map,
                "estimates": self._estimates,
                "simulator": self._simulator,
                "state": self._state,
                "ages": {},
                "graph": [],
                **self._supervision.snapshot(),
            }
            return picture if self._sources is None else _without_old_values(picture, self._sources, self._starting)

    def history(self) -> dict[str, Any]:
        """Trends and events since the beginning, for a page that opens."""
        with self._lock:
            return self._supervision.history()

    def take(self, request: Mapping[str, Any]) -> dict[str, Any]:
        """Carry out what a request says about alarms and limits; returns the rest of it.

        Raises:
            DrillTwinError: There is no such alarm, or a limit is impossible.
        """
        with self._lock:
            return self._supervision.take(request)

    def note(self, text: str) -> None:
        """Add an event to the log."""
        with self._lock:
            self._supervision.alarms.note(text, self._supervision.time)

    def check_sources(self) -> None:
        """Raise or end the alarms of nodes; to be called about once a second."""
        if self._sources is not None:
            with self._lock:
                self._supervision.nodes(self._sources.nodes())
                if (self._sources.age("analyzer") or 0.0) > GONE:
                    self._supervision.no_findings()

    def fill_trends(self, messages: Iterable[tuple[str, bytes]]) -> None:
        """Compute the trends of a recording from its messages."""
        rate = math.nan
        for topic, raw in messages:
            with suppress(MessageError):  # it is counted when it is played
                if topic == DIAGNOSTICS and _RATE.encode() in raw:
                    rate = next((_rate(s.values[_RATE]) for s in decode_diagnostics(raw)[1] if _RATE in s.values), rate)
                elif topic == RIG_STATE:
                    state = self._rig_reader(raw)
                    self._supervision.trends.push(seconds(state.stamp), {**_rig(read_rig_state(state)), "rop": rate})


def _without_old_values(picture: dict[str, Any], sources: Sources, starting: str) -> dict[str, Any]:
    """Add the ages of the sources, and take away what is gone; a simulator that is `starting` has no frames as yet."""
    ages = {source: sources.age(source) for source in ("simulator", "analyzer", "advisor", "estimator")}
    gone = {source for source, age in ages.items() if age is not None and age > GONE}
    picture |= {"ages": ages, "graph": sources.nodes()}
    if "simulator" in gone:
        text = f"no data of the simulator for {ages['simulator']:.0f} s"
        picture |= {"time": None, "nodes": [], "trail": {}, "rig": {}, "simulator": {"factor": "", "text": text}}
    if starting:
        text = next((row["text"] for row in picture["graph"] if row["name"] == starting), "the simulator has ended")
        picture["simulator"] = {"factor": "", "text": text}
    if ages["advisor"] is not None and ages["advisor"] > GONE:
        picture["advice"] = {"text": f"no advice for {ages['advisor']:.0f} s", "level": int(Level.STALE)}
    if "estimator" in gone:
        text = f"no estimates for {ages['estimator']:.0f} s"
        picture["estimates"] = {"level": int(Level.STALE), "text": text, "rows": []}
    if "analyzer" in gone:
        text = f"no findings of the analyzer for {ages['analyzer']:.0f} s"
        picture |= {"motion": {"state": "", "criterion": text}, "onset": None}
    of = {"simulator": ("x", "y", "z"), "analyzer": ("orbit", "precession", "motion")}
    hidden = {key for source in gone for key in of.get(source, ())}
    picture["marks"] = [{key: value for key, value in mark.items() if key not in hidden} for mark in picture["marks"]]
    return picture


def _rig(state: RigState) -> dict[str, float]:
    """Values of the rig by name [N, rev/s, N m]."""
    return {
        "wob": state.bit_force,
        "rps": state.top_drive_speed / math.tau,
        "torque": state.top_drive_torque,
        "bit_rps": state.bit_speed / math.tau,
        "bit_torque": state.bit_torque,
        "hookload": state.hookload,
    }


def _rate(text: str) -> float:
    """Rate of penetration [m/s] from the diagnostics [m/h]."""
    try:
        return float(text) / 3600.0
    except ValueError:
        raise MessageError(f"expected a number as rate of penetration, found {text[:40]!r}") from None


def _check_positions(positions: Array) -> None:
    """Raise MessageError for positions that cannot be drawn."""
    if not (np.abs(positions) < _LARGEST).all():
        raise MessageError(f"expected positions within {_LARGEST:g} m, found a larger or a missing one")


def _short(text: str) -> str:
    """A text for the page, of bounded length and without control characters."""
    return printable(text[:_LONGEST_TEXT], keep="")


def _number(value: float) -> float | None:
    """A number for JSON, which has no NaN."""
    return float(value) if math.isfinite(value) else None
