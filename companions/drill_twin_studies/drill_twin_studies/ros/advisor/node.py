# SPDX-License-Identifier: Apache-2.0
"""Advisor node: where the set-point lies in the operating map, and the nearest calmer set-point; without commands.

Where the node is given no map, `drill-twin map` makes a coarse map of the scene on the topics in a child process.
"""

import json
import math
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from types import SimpleNamespace

from drill_twin.core.errors import DrillTwinError, RunError
from drill_twin.core.process import child_environment
from drill_twin.io.messages.decode import JointState, read_string
from drill_twin.io.messages.diagnostics import Level, Status
from drill_twin.io.messages.encode import encode_string
from drill_twin.io.messages.good_samples import GONE
from drill_twin.io.messages.rig_messages import read_rig_state
from drill_twin.io.messages.stamps import seconds, stamp_ns
from drill_twin.io.messages.topic_words import digest_of
from drill_twin.io.messages.topics import ADVICE_MAP, ADVICE_STATE, DIAGNOSTICS, RIG_STATE, TWIN_SCENE, TWIN_SUMMARY
from drill_twin.ros.core.node import AUTOSTART, TwinNode
from drill_twin.ros.core.pacing import Tick
from drill_twin.ros.core.parameters import Parameter
from drill_twin.ros.core.policy import Rights
from drill_twin.scene import Scene, parse_scene
from drill_twin.whirl import MotionCode
from drill_twin_studies.maps.advice import Advice, Adviser, Tracker, encode_advice
from drill_twin_studies.maps.operating_map import OperatingMap, read_map

_LOW, _HIGH = 0.025, 1.1
"""Ranges that the map has by default, over the set-points of the scene."""
_STEPS = 8
_NICE = 10


class MapMaker:
    """A child process that makes the map, at low priority, so that the nodes keep real time."""

    def __init__(self, scene: Scene, settings: SimpleNamespace) -> None:
        """Start it.

        Args:
            scene: The scene.
            settings: Parameters `wob_range`, `rpm_range`, `runs` and `workers` of the node.

        Raises:
            DrillTwinError: No range is given, and the scene has no set-point to take one from.
        """
        rig = scene.rig
        wob = settings.wob_range or _range("wob", rig.weight_on_bit.value, "N")
        rpm = settings.rpm_range or _range("rpm", rig.rotation.value, "rad/s")
        self._runs = settings.runs
        self._folder = tempfile.TemporaryDirectory(prefix="drill_twin_map_")
        self._out = Path(self._folder.name)
        (self._out / "scene.yaml").write_text(scene.to_yaml(), "utf-8")
        words = ["map", str(self._out / "scene.yaml"), "--wob", wob, "--rpm", rpm, "--runs", str(settings.runs)]
        words += ["--steps", str(_STEPS), "--workers", str(settings.workers), "--out", str(self._out)]
        with (self._out / "log").open("wb") as log:
            self._process = subprocess.Popen(
                [sys.executable, "-m", "drill_twin.cli", *words], env=child_environment(), stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL, stderr=log, start_new_session=True,
            )  # fmt: skip
        os.setpriority(os.PRIO_PROCESS, self._process.pid, _NICE)

    @property
    def progress(self) -> str:
        """Runs made so far, as text."""
        journal = self._out / "runs.jsonl"
        made = max(journal.read_bytes().count(b"\n") - 1, 0) if journal.exists() else 0
        return f"no advice yet: making a coarse map, {made} of at most {self._runs} runs ({made / self._runs:.0%}) made"

    def result(self) -> OperatingMap | None:
        """The map, once it is made.

        Raises:
            RunError: The map could not be made.
        """
        code = self._process.poll()
        if code is None:
            return None
        if code:
            lines = (self._out / "log").read_text("utf-8", "replace").split("\n")
            said = next((line for line in reversed(lines) if line.strip()), f"exit code {code}")
            raise RunError(f"no map of this scene: {said.removeprefix('drill-twin: ')}")
        return read_map(self._out / "map.json")

    def close(self) -> None:
        """End the child, and remove its files."""
        if self._process.poll() is None:
            self._process.kill()
            self._process.wait()
        self._folder.cleanup()


def _range(name: str, value: float, unit: str) -> str:
    if not value > 0.0 or not math.isfinite(value):
        raise DrillTwinError(
            f"parameter {name}: expected a range for the map, found none, and {value:g} {unit} in the scene; "
            f'set it, as "10..100 {unit}"'
        )
    return f"{_LOW * value!r}..{_HIGH * value!r} {unit}"


_PERIOD = 0.1  # s of wall time between two looks at the map
_REPEAT = 1.0  # s of wall time


class Advisor(TwinNode):
    """Compares set-points and motion with a map, and publishes advice."""

    NAME = "advisor"
    PURPOSE = "Says where the set-point lies in the operating map, and the nearest calmer set-point; commands nothing."
    PARAMETERS = (
        Parameter("map", "", 'map.json of `drill-twin map`; "": make a coarse map of the scene on /twin/scene'),
        Parameter("wob_range", "", 'range of a map made here; "": up to 1.1 times the scene\'s', such_as="1..60 N"),
        Parameter("rpm_range", "", 'range of a map made here; "": up to 1.1 times the scene\'s', such_as="30..180 rpm"),
        Parameter("runs", 100, "largest number of runs of a map made here", "", 1, 1_000_000),
        Parameter("workers", 1, "threads of a map made here", "", 1, 4096),
        Parameter("margin", 0.05, "share of the ranges that an advised set-point keeps from a boundary", "", 0.0, 0.5),
        AUTOSTART,
    )
    ON_CHANGE = (TWIN_SCENE,)
    RIGHTS = Rights((DIAGNOSTICS, RIG_STATE, TWIN_SCENE, TWIN_SUMMARY))
    _maker: MapMaker | None = None

    def configure(self) -> None:
        """Read the map, and create topics and the timer of the advice.

        Raises:
            ArgumentError: The map cannot be read.
        """
        self._made: OperatingMap | None = None
        self._adviser: Adviser | None = None
        self._trouble = ""
        self._clear()
        self._given = read_map(self.settings.map) if self.settings.map else None
        for topic in (ADVICE_STATE, ADVICE_MAP):
            self.topics.advertise(topic)
        self.topics.subscribe_scenes(self._on_scene)
        self.topics.subscribe(RIG_STATE, self._on_rig, depth=1)
        self.topics.subscribe(TWIN_SUMMARY, self._on_summary)
        self.samples.expect(TWIN_SCENE)
        self.samples.expect(RIG_STATE)
        self.every(_PERIOD, self._look_at_map)

    def complete(self) -> None:
        """End a map that is being made."""
        self._drop_maker()

    def _clear(self) -> None:
        self._tracker = Tracker()
        self._whirls = False
        self._last: object = ()
        self._level = Level.OK
        self._repeat = Tick(_REPEAT)
        self._said = ""

    # --- inputs ---------------------------------------------------------------------------------------------------

    def _on_scene(self, raw: bytes) -> None:
        self._drop_maker()
        self.samples.take(TWIN_SCENE)
        self._adviser, self._trouble = None, ""
        self._clear()
        try:
            scene = parse_scene(read_string(raw), name=TWIN_SCENE)
            if self._given is not None:
                self._given.check_scene(scene)
            found = self._given or self._made
            if found is not None and found.digest == digest_of(scene):
                self._use(found)
            else:
                self._maker = MapMaker(scene, self.settings)
                self._publish(None)
        except DrillTwinError as error:
            self._fail(error)

    def _on_rig(self, state: JointState) -> None:
        rig = read_rig_state(state)
        finite = math.isfinite(rig.bit_force) and math.isfinite(rig.top_drive_speed)
        self.samples.take(RIG_STATE, finite=finite)
        if not finite:
            return
        if seconds(state.stamp) < self._tracker.time:  # a new run
            self._clear()
        self._tracker.take(seconds(state.stamp), rig.bit_force, rig.top_drive_speed)

    def _on_summary(self, state: JointState) -> None:
        code = state.position[state.index("whirl")]
        self.samples.take(TWIN_SUMMARY, finite=math.isfinite(code))
        self._whirls = code >= MotionCode.SYNCHRONOUS_WHIRL and code != MotionCode.CREEPING

    # --- advice ---------------------------------------------------------------------------------------------------

    def _look_at_map(self) -> None:
        """Take the map once it is made, and advise."""
        if self._maker is not None:
            found = None
            try:
                found = self._maker.result()
            except DrillTwinError as error:
                self._fail(error)
            if found is not None:
                self._made = found
                self._use(found)
            if found is not None or self._trouble:
                self._drop_maker()
            elif self._repeat.due():
                self._publish(None)
        if self._adviser is not None and self._tracker.time >= 0.0:
            self._advise(self._adviser)

    def _use(self, found: OperatingMap) -> None:
        from drill_twin_studies.maps.drawing import lattice_data  # takes long

        self._adviser = Adviser(found, self.settings.margin)
        self.topics.publish(ADVICE_MAP, encode_string(json.dumps(lattice_data(found))))
        self.get_logger().info(f"map of {found.name}: {len(found.records)} runs of {found.duration:g} s")

    def _fail(self, error: DrillTwinError) -> None:
        self._trouble = str(error)
        self.get_logger().error(self._trouble)
        self._publish(None)

    def _advise(self, adviser: Adviser) -> None:
        advice = self._tracker.advise(adviser, whirls=self._whirls)
        if (silence := self.samples.verdict()[1]) and self.samples.age(RIG_STATE) > GONE:
            advice, text = None, f"no advice: {silence}"
        else:
            text = self._tracker.waits_for if advice is None else advice.text
        now = text if advice is None else (advice.level, advice.target, advice.regime, self._whirls)
        if (changed := now != self._last) or self._repeat.due():
            self._last, self._said = now, text
            self._level = Level.WARN if advice is not None and advice.level is Level.ERROR else Level.OK
            self._publish(advice, told=changed)

    def _publish(self, advice: Advice | None, *, told: bool = True) -> None:
        """Publish advice, and where it is another one the sentence in the diagnostics too."""
        tracker = self._tracker
        stamp = stamp_ns(max(tracker.time, 0.0))
        raw = encode_advice(stamp, advice, tracker.weight, tracker.speed, whirls=self._whirls)
        self.topics.publish(ADVICE_STATE, raw)
        if told:
            self.publish_diagnostics()

    def _drop_maker(self) -> None:
        if self._maker is not None:
            self._maker.close()
            self._maker = None

    def health(self) -> Status:
        """Level and sentence: gaps of its inputs, progress of the map, or the last advice."""
        level, silence = self.samples.verdict()
        progress = self._maker.progress if self._maker is not None and level is Level.OK else ""
        said = self._level, self._said or "no advice yet"
        trouble = Level.ERROR, self._trouble
        return self.status(self.samples.values(), trouble, (Level.OK, progress), (level, silence), said)
