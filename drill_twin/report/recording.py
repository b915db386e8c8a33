# SPDX-License-Identifier: Apache-2.0
"""A bag read once from front to back: the run as arrays over time, and what the analysis finds in it.

The findings come from the same pipeline as the live analyzer's, fed with the recorded bytes; where the bag holds the
live findings too, the two are compared byte for byte.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from drill_twin.base.arrays import Array, ComplexArray
from drill_twin.errors import BagError, MessageError
from drill_twin.io.bag.reader import Bag
from drill_twin.io.messages.decode import JointState, JointStateReader, read_pose_array, read_string
from drill_twin.io.messages.diagnostics import decode_diagnostics
from drill_twin.io.messages.encode import RIG_JOINTS, read_command, read_rig_state
from drill_twin.io.messages.stamps import NANOSECONDS, seconds, unpack_stamp
from drill_twin.io.messages.topics import (
    DIAGNOSTICS,
    MARKS_STATE,
    RIG_COMMAND,
    RIG_STATE,
    STRING_POSES,
    TWIN_SCENE,
    WHIRL_ONSET,
    WHIRL_STATE,
)
from drill_twin.io.messages.whirl_encode import OnsetMessage, decode_onset
from drill_twin.io.whirl_pipeline import WhirlPipeline, columns, speeds
from drill_twin.monitor.missing_effects import recorded_missing_effects
from drill_twin.monitor.rejected_steps import RecordedRejections
from drill_twin.report.curve import along_hole, smooth, tangents
from drill_twin.report.locate import bag_in, finite_number, no_samples, no_scene, run_block
from drill_twin.report.selection import Selection, described, lacking, open_bag
from drill_twin.report.track import Track
from drill_twin.scene import Scene
from drill_twin.twin.frame import COUNTS
from drill_twin.whirl import Findings, MarkInfo, Summary
from drill_twin.whirl.bit_only_analyzer import NOT_OBSERVABLE

SHAPES = 600
"""Most shapes of the string that are kept, evenly over the run."""

STAMPED = frozenset({MARKS_STATE, RIG_STATE, RIG_COMMAND, STRING_POSES, WHIRL_STATE})
"""Topics whose messages begin with a header, so that they can be chosen by time."""


@dataclass(eq=False)
class Live:
    """What the analyzer that ran with the twin recorded, beside what the analysis of the bag gives."""

    onset: OnsetMessage | None = None
    """The onset it announced."""
    messages: int = 0
    """Messages on `/whirl/state`."""
    differing: int = 0
    """Those that differ from the analysis of the bag in any byte."""


class Recording:
    """A run read from a bag; where a bag holds several runs, the last one."""

    def __init__(self, bag: Bag, scene: Scene | None = None, selection: Selection | None = None) -> None:
        """Read and analyse the bag.

        Args:
            bag: The bag.
            scene: The scene it belongs to, where it does not say so itself.
            selection: What of it is analysed; all of it where none.

        Raises:
            BagError: It holds neither marks nor rig states, marks but no scene, or messages that cannot be decoded.
            AnalysisError: A mark that was asked for is not among those of the scene.
        """
        self.bag = bag
        self.selection = selection or Selection()
        self.run_info: dict[str, Any] = {}
        self._scene: Scene | None = None
        infos = described(bag, self.selection) if scene is None else ()
        self._lacks = lacking(bag)
        self._pipeline = WhirlPipeline(scene, lacks=self._lacks, marks=self.selection.marks, infos=infos)
        self._pipeline.start()
        self._pose_count = bag.topics[STRING_POSES].count if STRING_POSES in bag.topics else 0
        self._forget()
        self._read()
        self.summary: Summary = self._checked_summary()

    def _checked_summary(self) -> Summary:
        pipeline = self._pipeline
        if pipeline.blind is not None and pipeline.blind.quality.accepted:
            return pipeline.summary()
        if pipeline.blind is None and not pipeline.marks:
            raise BagError(no_scene(self.bag, pipeline.trouble))
        if pipeline.findings is None:
            raise BagError(no_samples(self.bag, pipeline))
        summary = pipeline.summary()
        if RIG_STATE in self._lacks and not summary.quality.accepted:
            raise BagError(
                f"{self.bag.path}: expected the rotation, as top_drive on {RIG_STATE} or as the spin of the marks, "
                "found neither; without rotation whirl is not defined"
            )
        return summary

    @property
    def rotation_from_spin(self) -> bool:
        """Whether the rotation was taken from the spin of the marks, because there are no rig states."""
        return RIG_STATE in self._lacks

    @property
    def scene(self) -> Scene:
        """The scene of the run.

        Raises:
            BagError: Neither the bag nor anyone has told.
        """
        if self._scene is not None:
            return self._scene
        if self._pipeline.scene is None:
            raise BagError(no_scene(self.bag, self._pipeline.trouble))
        return self._pipeline.scene

    @scene.setter
    def scene(self, scene: Scene) -> None:
        self._scene = scene

    @property
    def scene_known(self) -> bool:
        """Whether the scene is known."""
        return self._scene is not None or self._pipeline.scene is not None

    @property
    def places(self) -> tuple[MarkInfo, ...]:
        """The marks that are analysed."""
        return self._pipeline.marks if self._pipeline.blind is None else ()

    @property
    def findings(self) -> Findings:
        """The findings after the last sample.

        Raises:
            BagError: Whirl is not observable in this bag.
        """
        if self._pipeline.findings is None:
            raise BagError(
                f"{self.bag.path}: expected positions of marks on {MARKS_STATE}, found none; {NOT_OBSERVABLE}"
            )
        return self._pipeline.findings

    def _forget(self) -> None:
        """Begin a new run."""
        self.marks, self.rig, self.commands = Track(), Track(), Track()
        """Marks x, y, z, spin, shape (T, m, 4); weight on bit [N], top and bit speed [rad/s], bit torque, hookload;
        commanded weight on bit [N] and speed [rad/s]."""
        self.poses = Track()
        """Position [m] and unit tangent of the nodes, at most `SHAPES` times, shape (T, 2, n + 1, 3)."""
        self.orbits = Track()
        """Orbit radius [m], precession [rev/s], ratio, confidence, shape (T, 4, m)."""
        self.live = Live()
        self.realtime_factor: float | None = None
        self.steps: dict[str, int] = {}
        self.left_out: list[str] = []
        self.guard = RecordedRejections()
        self._every, self._seen = max(1, -(-self._pose_count // SHAPES)), 0
        self._decoders = {topic: JointStateReader().read for topic in (MARKS_STATE, RIG_STATE, RIG_COMMAND)}
        self._found: dict[int, bytes] = {}
        self._recorded: dict[int, bytes] = {}

    # --- reading --------------------------------------------------------------------------------------------------

    def _read(self) -> None:
        readers = {
            MARKS_STATE: self._on_marks,
            RIG_STATE: self._on_rig,
            RIG_COMMAND: self._on_command,
            STRING_POSES: self._on_poses,
            TWIN_SCENE: self._on_scene,
            WHIRL_STATE: self._on_whirl,
            WHIRL_ONSET: self._on_onset,
            DIAGNOSTICS: self._on_diagnostics,
        }
        for topic, stamp, raw in self.bag.messages(tuple(readers)):
            if topic in STAMPED and not self.selection.holds(unpack_stamp(raw, 4) if len(raw) >= 12 else 0):
                continue
            runs = self._pipeline.runs
            found = self._pipeline.take(topic, raw)
            if self._pipeline.runs > max(runs, 1):
                self._forget()
            for name, message in found:
                if name == WHIRL_STATE and self._pipeline.findings is not None:
                    self._on_findings(self._pipeline.findings, message)
            try:
                readers[topic](raw)
            except MessageError as error:
                raise BagError(f"{self.bag.path}: {topic} recorded at {stamp} ns: {error}") from error
        if self.selection.whole:
            self.live.differing = sum(self._found.get(stamp) != raw for stamp, raw in self._recorded.items())
            self.live.messages = len(self._recorded)

    def _joints(self, topic: str, raw: bytes) -> JointState:
        return self._decoders[topic](raw)

    def _on_marks(self, raw: bytes) -> None:
        state = self._joints(MARKS_STATE, raw)
        names = [name.removesuffix("/x") for name in state.names if name.endswith("/x")]
        if not names or not state.position.size:
            raise MessageError(f"expected x, y, z and spin of marks, found {', '.join(state.names) or 'nothing'}")
        self.marks.add(state.stamp, np.append(state.position, np.nan)[columns(state.names, names)])

    def _on_rig(self, raw: bytes) -> None:
        state = self._joints(RIG_STATE, raw)
        if state.names != RIG_JOINTS:  # another rig's: its speeds are all that is needed
            top, bit = speeds(state)
            self.rig.add(state.stamp, (math.nan, top, bit, math.nan, math.nan))
            return
        rig = read_rig_state(state)
        self.rig.add(state.stamp, (rig.bit_force, rig.top_drive_speed, rig.bit_speed, rig.bit_torque, rig.hookload))

    def _on_command(self, raw: bytes) -> None:
        state = self._joints(RIG_COMMAND, raw)
        command = read_command(state)
        self.commands.add(state.stamp, (command.weight_on_bit, command.rotation))

    def _on_poses(self, raw: bytes) -> None:
        if self._seen % self._every == 0:
            poses = read_pose_array(raw)
            self.poses.add(poses.stamp, (poses.position, tangents(poses.orientation)))
        self._seen += 1

    def _on_scene(self, raw: bytes) -> None:
        self.run_info = run_block(read_string(raw)) or self.run_info

    def _on_findings(self, findings: Findings, raw: bytes) -> None:
        self._found[findings.stamp_ns] = raw
        row = (findings.orbit_radius, findings.precession, findings.ratio, findings.confidence)
        self.orbits.add(findings.stamp_ns, np.array(row))

    def _on_whirl(self, raw: bytes) -> None:
        stamp = int.from_bytes(raw[4:8], "little", signed=True) * NANOSECONDS + int.from_bytes(raw[8:12], "little")
        self._recorded[stamp] = raw

    def _on_onset(self, raw: bytes) -> None:
        self.live.onset = decode_onset(raw)[1]

    def _on_diagnostics(self, raw: bytes) -> None:
        for status in decode_diagnostics(raw)[1]:
            if status.name.rpartition("/")[2] in {"simulator", "twin"} and "realtime_factor" in status.values:
                factor = finite_number(status.values["realtime_factor"])
                self.realtime_factor = self.realtime_factor if factor is None else factor
                self.steps |= {k: int(status.values[k]) for k in COUNTS if status.values.get(k, "").isdecimal()}
                self.left_out = recorded_missing_effects(status.values)
                self.guard.update(status.values)

    # --- what the others ask --------------------------------------------------------------------------------------

    @property
    def path(self) -> Path:
        """The bag."""
        return self.bag.path

    @property
    def runs(self) -> int:
        """How many runs the bag holds; this is the last."""
        return max(1, self._pipeline.runs)

    @property
    def duration(self) -> float:
        """Simulated time of the last sample [s]."""
        if self._pipeline.blind is not None:
            return float(self.rig.time[-1]) if len(self.rig) else 0.0
        return seconds(self.findings.stamp_ns)

    @property
    def nodes(self) -> int:
        """Nodes of the string; 0 where the bag holds no poses."""
        return self.poses.values.shape[2] if len(self.poses) else 0

    @property
    def unusable(self) -> int:
        """Messages the analysis could not use, or whose partner is missing."""
        return self._pipeline.malformed + self._pipeline.unpaired

    @property
    def trouble(self) -> str:
        """What was wrong with the last of them."""
        return self._pipeline.trouble

    def shapes(self) -> Array:
        """Curves of the string along the hole [m] at the times of the poses, shape (T, k, 3), from the bit up."""
        values = self.poses.values
        return along_hole(self.scene, smooth(values[:, 0], values[:, 1]))

    def centre_lines(self) -> ComplexArray:
        """Centre line z = x + i y at the marks [m], the spin of wall marks taken off, shape (T, m)."""
        marks = self.marks.values
        offset = np.array([place.wall_offset for place in self.scene.mark_table])
        centre: ComplexArray = marks[..., 0] + 1j * marks[..., 1] - offset * np.exp(1j * marks[..., 3])
        return centre


def read_recording(path: str | Path, scene: Scene | None = None, selection: Selection | None = None) -> Recording:
    """Open and analyse a bag, or the bag in the folder of a run.

    Raises:
        BagError: Not a bag of this package, or nothing in it that could be analysed.
    """
    return Recording(open_bag(bag_in(path), selection or Selection()), scene, selection)
