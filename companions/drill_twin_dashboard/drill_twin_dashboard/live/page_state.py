# SPDX-License-Identifier: Apache-2.0
"""State of the live page: the latest values of the topics, of a running twin or of a bag."""

import math
import threading
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from typing import Any, ClassVar

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.errors import DrillTwinError, MessageError
from drill_twin.core.severity import worst
from drill_twin.io.bag.skipped import SkippedMessages
from drill_twin.io.findings_encoder import BIT, LATERAL
from drill_twin.io.messages.decode import JointState, PoseArray
from drill_twin.io.messages.diagnostics import Level, Status
from drill_twin.io.messages.encode import MARK_AXES
from drill_twin.io.messages.good_samples import GONE
from drill_twin.io.messages.readers import reader_of
from drill_twin.io.messages.rig_messages import read_rig_state
from drill_twin.io.messages.stamps import seconds
from drill_twin.io.messages.topic_words import digest_of
from drill_twin.io.messages.topics import (
    ADVICE_MAP,
    ADVICE_STATE,
    DIAGNOSTICS,
    ESTIMATE_STATE,
    MARKS_STATE,
    RIG_STATE,
    STRING_POSES,
    TWIN_SCENE,
    TWIN_SUMMARY,
    WHIRL_MOTION,
    WHIRL_ONSET,
    WHIRL_STATE,
)
from drill_twin.io.messages.whirl_encode import STRING_LEVEL, OnsetMessage, SubjectMotion, read_whirl_state
from drill_twin.report.quantities import string_weight
from drill_twin.report.string_curve import along_hole
from drill_twin.scene import Scene, parse_scene
from drill_twin.whirl import MotionCode
from drill_twin_dashboard.live.shown import (
    Sources,
    number,
    rig_values,
    short,
    shown_advice,
    shown_estimates,
    shown_map,
    shown_scene,
    without_old_values,
)
from drill_twin_dashboard.live.supervision import UNKNOWN, Supervision, lamp

_TRAIL = 400  # most positions of a mark between two snapshots
_LARGEST = 1e6  # m
_SPEAKERS = ("advisor", "estimator")
"""Nodes whose sentence in `/diagnostics` the page shows beside their numbers."""
_MOST_MARKS, _MOST_NODES = 200, 20_000


class PageState:
    """Latest values of the topics; `update` and `snapshot` may be called from different threads."""

    def __init__(self, sources: Sources | None = None) -> None:
        """Start empty.

        Args:
            sources: Freshness of the sources of a running twin, whose values disappear when they are old; None for a
                recording, whose values stay.
        """
        self._sources = sources
        self._lock = threading.RLock()
        self._supervision = Supervision(recorded=sources is None)
        self._state = ""  # of the simulator, which another scene does not change
        self._read = {topic: reader_of(topic) for topic in INPUTS}
        self.skipped = SkippedMessages()
        """Messages that could not be used."""
        self.units = ""
        """System of units that the reader asked for; empty: the scene's."""
        self.clear()

    def clear(self) -> None:
        """Drop all values, for a new run or another time of the recording."""
        with self._lock:
            self._hole: Scene | None = None
            self._weight = math.nan
            self._marks: dict[str, dict[str, Any]] = {}
            self._trail: dict[str, list[list[float]]] = {}
            self._rig: dict[str, float] = {}
            self._said = dict.fromkeys(_SPEAKERS, "")  # sentence of each of these nodes
            self._starting = ""  # name of the simulator while it compiles or is not configured
            self.shown: dict[str, Any] = {  # what the page gets as it is
                "time": 0.0, "scene": None, "nodes": [], "motion": {"state": "", "criterion": "", "whirls": False},
                "onset": None, "advice": {"level": 0}, "map": None, "estimates": None,
                "simulator": {"factor": "", "text": ""},  # real-time factor, and a sentence on it
            }  # fmt: skip

    def update(self, topic: str, raw: bytes) -> None:
        """Decode a message; a message that cannot be used is skipped and counted."""
        try:
            with self._lock:
                if topic in self.HANDLERS:
                    self.HANDLERS[topic](self, self._read[topic](raw))
                if self._sources is not None:
                    empty = topic == RIG_STATE and not any(map(math.isfinite, self._rig.values()))
                    self._sources.message(topic, finite=not empty)
        except DrillTwinError as error:
            self.skipped.add(topic, self.shown["time"], error)

    def _on_poses(self, poses: PoseArray) -> None:
        _check_positions(poses.position)
        nodes = poses.position
        if len(nodes) > _MOST_NODES:
            raise MessageError(f"expected at most {_MOST_NODES} positions, found {len(nodes)}")
        if self._hole is not None:
            nodes = along_hole(self._hole, nodes[None])[0]
        self.shown |= {"time": seconds(poses.stamp), "nodes": nodes.round(6).tolist()}

    def _on_rig(self, state: JointState) -> None:
        rig = read_rig_state(state)
        drag = rig.hookload + rig.bit_force - self._weight
        self._rig = {**rig_values(rig), "drag": drag}
        self._supervision.rig(seconds(state.stamp), self._rig)

    def _on_whirl(self, state: JointState) -> None:
        for name, (radius, precession, *_) in zip(*read_whirl_state(state), strict=True):
            self._mark(name).update(orbit=number(radius), precession=number(precession / math.tau))

    def _on_onset(self, found: tuple[int, OnsetMessage | None]) -> None:
        onset = found[1]
        self.shown["onset"] = None if onset is None else {"time": number(onset.time), "mark": short(onset.mark)}

    def _on_summary(self, state: JointState) -> None:
        values = dict(zip(state.names, state.position.tolist(), strict=False))
        try:
            code = MotionCode(int(values["whirl"]))
        except (KeyError, ValueError, OverflowError) as error:
            raise MessageError(f"expected the code of the motion on {TWIN_SUMMARY}, found none") from error
        self.shown["motion"]["whirls"] = code.whirls
        parts = ((*name.partition("/"), value) for name, value in values.items())
        lateral = [(kind, value, short(mark)) for kind, _, mark, value in parts if kind in LATERAL and value >= 0.0]
        self._supervision.light("whirl", lamp(code.state.value, worst(lateral, self._supervision.bounds)))

    def _on_motion(self, found: tuple[int, list[SubjectMotion]]) -> None:
        for motion in found[1]:
            if motion.subject == STRING_LEVEL:
                self.shown["motion"] |= {"state": short(motion.state), "criterion": short(motion.criterion)}
            elif motion.subject != BIT:
                self._mark(motion.subject)["motion"] = short(motion.state)

    def _mark(self, name: str) -> dict[str, Any]:
        if name not in self._marks and len(self._marks) >= _MOST_MARKS:
            raise MessageError(f"expected at most {_MOST_MARKS} marks on {MARKS_STATE} and {WHIRL_MOTION}, found more")
        return self._marks.setdefault(name, {"name": short(name)})

    def _on_marks(self, state: JointState) -> None:
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

    def _on_scene(self, text: str) -> None:
        scene, found = parse_scene(text, name=TWIN_SCENE), self.shown["map"]
        self.clear()
        if found is not None and found["digest"] == digest_of(scene):  # a map may come before its scene
            self.shown["map"] = found
        self._hole = scene if scene.hole.survey else None
        self._weight = string_weight(scene)
        self._supervision.begin(scene.name, scene.severity_bounds)
        self.shown["scene"] = shown_scene(scene)

    def _on_diagnostics(self, message: tuple[int, list[Status]]) -> None:
        for status in message[1]:
            if self._sources is not None:
                self._sources.report(status)
            if (node := status.name.rpartition("/")[2]) in _SPEAKERS:
                self._said[node] = short(status.text)
                if node == "estimator" and (found := self.shown["estimates"]) is not None:
                    self._supervision.estimate(found["level"], self._said[node])
            if "compiling" in status.values:
                self._starting = status.name
                self.shown["simulator"] = {"factor": "", "text": status.text}
            if "realtime_factor" in status.values:
                values, self._starting = status.values, ""
                self._state = short(values.get("state", ""))
                factor = short(values.get("realtime_factor_last_second", values["realtime_factor"]))
                pace = values.get("pace", "") if status.level == Level.OK else status.text
                self.shown["simulator"] = {"factor": factor, "text": short(pace)}

    def snapshot(self) -> dict[str, Any]:
        """All values as plain types for JSON, with the positions of the marks since the last snapshot."""
        with self._lock:
            trail, self._trail = self._trail, {}
            shown = self.shown
            picture = {
                **shown, "units": self.units, "marks": [dict(mark) for mark in self._marks.values()], "trail": trail,
                "rig": {name: number(value) for name, value in self._rig.items()},
                "advice": {**shown["advice"], "text": self._said["advisor"]},
                "estimates": shown["estimates"] and {**shown["estimates"], "text": self._said["estimator"]},
                "state": self._state, "ages": {}, "graph": [], **self._supervision.snapshot(),
            }  # fmt: skip
            return picture if self._sources is None else without_old_values(picture, self._sources, self._starting)

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
                    self._supervision.lamps["whirl"] = UNKNOWN

    def fill_trends(self, messages: Iterable[tuple[str, bytes]]) -> None:
        """Compute the trends of a recording from its messages."""
        for topic, raw in messages:
            with suppress(MessageError):  # the message is counted when it is played
                if topic == RIG_STATE:
                    state = self._read[RIG_STATE](raw)
                    self._supervision.trends.push(seconds(state.stamp), rig_values(read_rig_state(state)))

    HANDLERS: ClassVar[dict[str, Callable[[Any, Any], None]]] = {
        TWIN_SCENE: _on_scene,
        STRING_POSES: _on_poses,
        MARKS_STATE: _on_marks,
        RIG_STATE: _on_rig,
        WHIRL_STATE: _on_whirl,
        WHIRL_MOTION: _on_motion,
        WHIRL_ONSET: _on_onset,
        ADVICE_STATE: lambda page, state: page.shown.update(advice=shown_advice(state)),
        ADVICE_MAP: lambda page, text: page.shown.update(map=shown_map(text)),
        ESTIMATE_STATE: lambda page, state: page.shown.update(estimates=shown_estimates(state)),
        TWIN_SUMMARY: _on_summary,
        DIAGNOSTICS: _on_diagnostics,
    }
    """Function that takes the decoded message of each topic."""


INPUTS = tuple(PageState.HANDLERS)
"""Topics that the page shows."""


def _check_positions(positions: Array) -> None:
    """Raise MessageError for positions that cannot be drawn."""
    if not (np.abs(positions) < _LARGEST).all():
        raise MessageError(f"expected positions within {_LARGEST:g} m, found a larger or a missing one")
