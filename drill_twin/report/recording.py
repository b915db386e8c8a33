# SPDX-License-Identifier: Apache-2.0
"""A run read from a bag in one pass: its topics as arrays over time, and the findings of the whirl analysis.

The recorded bytes go through the pipeline of the analyzer node; where the bag holds live findings too, the two are
compared byte for byte.
"""

import math
from collections.abc import Callable, Collection
from contextlib import suppress
from itertools import islice
from pathlib import Path

import numpy as np

from drill_twin.core.arrays import Array, ComplexArray
from drill_twin.core.errors import BagError, MessageError
from drill_twin.core.units.system import unit_system
from drill_twin.io.bag.reader import Bag
from drill_twin.io.bag.series import (
    CommandSeries,
    JointSeries,
    MarkSeries,
    PoseSeries,
    RigSeries,
    StressSeries,
    WhirlSeries,
)
from drill_twin.io.bag.skipped import SkippedMessages
from drill_twin.io.bag.time_series import Rows
from drill_twin.io.bag.virtual_bags import RecordBag
from drill_twin.io.messages.encode import MARK_AXES
from drill_twin.io.messages.stamps import raw_header_stamp, seconds
from drill_twin.io.messages.topics import (
    DIAGNOSTICS,
    MARKS_STATE,
    RIG_COMMAND,
    RIG_STATE,
    STRING_POSES,
    STRING_STRESS,
    TWIN_SCENE,
    WHIRL_ONSET,
    WHIRL_STATE,
)
from drill_twin.io.scene_geometry import readings_topic
from drill_twin.io.whirl_pipeline import WhirlPipeline
from drill_twin.report.run_log import LiveFindings, RunLog
from drill_twin.report.selection import (
    Message,
    SelectedMessages,
    Selection,
    marks_without_scene,
    missing_topics,
    no_rotation,
    no_samples,
    no_scene,
    open_bag,
    sub_without_marks,
)
from drill_twin.report.string_curve import along_hole, smooth
from drill_twin.scene import Scene
from drill_twin.whirl import Findings, MarkInfo, Summary
from drill_twin.whirl.analyzer import NOT_OBSERVABLE
from drill_twin.whirl.marks import centre_lines

SHAPES = 600
"""Most poses of the string that are kept, evenly over the run."""


class Recording:
    """A run read from a bag; where a bag holds several runs, the last one or the selected one.

    Attributes:
        bag, path: The bag, and its path.
        rotation_from_spin: Whether the rotation was taken from the spin of the marks, since the bag has no rig states.
        selection: The part of it that is analysed.
        marks, rig, commands, stress: Positions and spins of marks, state of the rig, set-points, stress and damage.
        poses: Poses of the string's nodes, at most `SHAPES` of them.
        whirl, live, summary: Findings of the analysis over time, recorded while the twin ran, and for the whole run.
        log, skipped: `run` block and diagnostics; messages that could not be used.
        sub: Downhole sub whose readings are analysed instead of marks; empty without.
        units: Units in which people read it: the selection's, else the scene's, else the record's, else `si`.
        run, runs: Number of this run, from 1, and of runs in the bag.
        unpaired: Number of states of the marks or the rig without a partner of the same stamp.
    """

    def __init__(self, bag: Bag, scene: Scene | None = None, selection: Selection | None = None) -> None:
        """Read and analyse a bag.

        Args:
            bag: The bag.
            scene: The scene of the run; by default the one on `/twin/scene`.
            selection: The part that is analysed; by default all.

        Raises:
            BagError: The bag holds neither marks nor rig states, or marks but no scene.
            AnalysisError: The scene lacks a selected mark.
        """
        self.bag, self.path = bag, bag.path
        chosen = self.selection = selection or Selection()
        self.log, self.skipped = RunLog(), SkippedMessages()
        infos = marks_without_scene(bag, self.selection) if scene is None else ()
        self._missing = missing_topics(bag)
        self.rotation_from_spin = RIG_STATE in self._missing
        self.sub = self.selection.sub or (sub_without_marks(bag) if MARKS_STATE in self._missing else "")
        self._sub_topic = readings_topic(self.sub) if self.sub else ""
        self._pipeline = WhirlPipeline(
            scene, lacks=self._missing, marks=chosen.marks, infos=infos, sub=self.sub, run=chosen.run
        )
        self._messages = SelectedMessages(bag, self.selection, {self._sub_topic} if self.sub else set())
        self._poses_before = 0  # poses of the string in earlier runs
        self._reset()
        for batch in self._messages.batches(tuple(self._readers), self.skipped):
            read = self._read_batch(batch)  # many at once where they are as drill_twin records them
            for topic, raw, time in batch:
                if topic not in read:
                    self._read_message(topic, raw, time)
            if read:
                self._latest = batch[-1][2]
                self._behind.clear()
        self.runs = max(1, self._pipeline.runs)
        self.run = self.selection.run or self.runs
        if self.run > self.runs:
            raise BagError(f"--run: expected a run of {self.path}, 1 to {self.runs}, found {self.run}")
        for topic, series in self._series.items():
            if topic not in self.skipped:  # messages of another scene than most, unless the analysis has them
                for stamp, count, reason in series.other_layouts():
                    self.skipped.add(topic, seconds(stamp), reason, count)
        self.summary: Summary = self._checked_summary()
        own = self.scene.unit_system.name if self.scene_known else bag.units if isinstance(bag, RecordBag) else "si"
        self.units = unit_system(self.selection.units or own)
        self.unpaired = self._pipeline.pairing.unpaired

    def _reset(self) -> None:
        """Begin a new run."""
        self.marks, self.rig, self.commands = MarkSeries(), RigSeries(), CommandSeries()
        self.poses = PoseSeries(every=max(1, -(-self._messages.poses // SHAPES)))
        self.whirl, self.stress, self.live = WhirlSeries(), StressSeries(), LiveFindings()
        self._latest, self._behind = -math.inf, list[Message]()  # messages behind may be of the next run
        self.log = RunLog(self.log.info)
        self._series: dict[str, JointSeries | PoseSeries] = {
            **({} if self.sub else {MARKS_STATE: self.marks}),
            RIG_STATE: self.rig,
            RIG_COMMAND: self.commands,
            STRING_POSES: self.poses,
            STRING_STRESS: self.stress,
        }
        self._readers: dict[str, Callable[[bytes], None]] = {
            **{topic: series.add_message for topic, series in self._series.items()},
            **({self._sub_topic: self._add_place} if self.sub else {}),
            TWIN_SCENE: self.log.on_scene,
            WHIRL_ONSET: self.live.on_onset,
            DIAGNOSTICS: self.log.on_diagnostics,
            **({WHIRL_STATE: self.live.on_state} if self.selection.whole else {}),
        }

    def _read_batch(self, batch: list[Message]) -> Collection[str]:
        """Read the messages of a batch that can be analysed at once; return their topics."""
        raws: dict[str, list[bytes]] = {}
        for topic, raw, _ in batch:
            raws.setdefault(topic, []).append(raw)
        rows: dict[str, Rows] = {}
        if TWIN_SCENE in raws or self.sub:
            return rows
        for topic in raws.keys() & self._series.keys():
            with suppress(MessageError):
                if (found := self._series[topic].read(raws[topic])) is not None:
                    rows[topic] = found
        rig, marks = (rows[topic].states if topic in rows else None for topic in (RIG_STATE, MARKS_STATE))
        findings = None if rig is None else self._pipeline.analyse_states(rig, marks)
        if findings is None:
            return ()
        if self._pipeline.bit_only is None:
            states = [raw for messages in findings for topic, raw in messages if topic == WHIRL_STATE]
            for raw in states:
                self.live.on_analysed(raw)
            if states and (found := self.whirl.read(states)) is not None:
                self.whirl.extend(found)
        for topic, found in rows.items():
            self._series[topic].extend(found)
        return rows

    def _read_message(self, topic: str, raw: bytes, time: float) -> None:
        runs, malformed = self._pipeline.runs, self._pipeline.malformed
        messages = self._pipeline.analyse(topic, raw)
        if self._pipeline.over:
            return
        if time >= self._latest:
            self._latest, self._behind = time, []
        elif topic != TWIN_SCENE:
            self._behind.append((topic, raw, time))
        if self._pipeline.runs > max(runs, 1):
            first = [one for one in self._behind[:-1] if topic != TWIN_SCENE and one[2] <= time]
            self._poses_before += self.poses.seen - sum(one[0] == STRING_POSES for one in first)
            self._reset()
            for name, behind, _ in first:
                with suppress(MessageError):  # counted already
                    self._readers[name](behind)
        reason = self._pipeline.trouble if self._pipeline.malformed > malformed else ""
        for name, message in messages:
            if name == WHIRL_STATE:
                self.live.on_analysed(message)
                if seconds(raw_header_stamp(message)) <= time:  # a later one is of the run before
                    self.whirl.add_message(message)
        try:
            self._readers[topic](raw)
        except MessageError as error:
            reason = str(error)
        if reason:
            self.skipped.add(topic, time, reason)

    def _add_place(self, _: bytes) -> None:
        """Append the place of the sub's section, about its mean, as if the section were a mark."""
        section = self._pipeline.section
        if section is not None and (place := section.place) is not None:
            mark, row = self._pipeline.marks[0], np.full((3, 1, len(MARK_AXES)), np.nan)
            height = mark.distance_from_bit - self.scene.length
            row[0, 0] = place.position.real, place.position.imag, height, place.spin
            self.marks.append(place.stamp, row, (mark.name,))

    def _checked_summary(self) -> Summary:
        pipeline = self._pipeline
        if pipeline.bit_only is not None and pipeline.bit_only.quality.accepted:
            return pipeline.summary()
        if pipeline.bit_only is None and not pipeline.marks:
            raise BagError(no_scene(self.path, self._pipeline.trouble, of_sub=bool(self.sub)))
        if pipeline.findings is None:
            raise BagError(no_samples(self.bag, self.selection, self.sub, self._pipeline.trouble))
        summary = pipeline.summary()
        if (self.sub or self.rotation_from_spin) and not summary.quality.accepted:
            raise BagError(no_rotation(self.path, self.sub))
        return summary

    @property
    def scene(self) -> Scene:
        """Scene of the run; raises BagError where it is not known."""
        if self._pipeline.scene is None:
            raise BagError(no_scene(self.path, self._pipeline.trouble, of_sub=bool(self.sub)))
        return self._pipeline.scene

    @property
    def scene_known(self) -> bool:
        """True where `scene` is known."""
        return self._pipeline.scene is not None

    @property
    def places(self) -> tuple[MarkInfo, ...]:
        """Analysed marks; empty where whirl is not observable."""
        return self._pipeline.marks if self._pipeline.bit_only is None else ()

    @property
    def findings(self) -> Findings:
        """Findings at the last sample; raises BagError where whirl is not observable."""
        if self._pipeline.findings is None:
            raise BagError(f"{self.path}: expected positions of marks on {MARKS_STATE}, found none; {NOT_OBSERVABLE}")
        return self._pipeline.findings

    @property
    def duration(self) -> float:
        """Simulated time of the last sample [s]."""
        if self._pipeline.bit_only is not None:
            return float(self.rig.time[-1]) if len(self.rig) else 0.0
        return seconds(self.findings.stamp_ns)

    @property
    def nodes(self) -> int:
        """Nodes of the string; 0 where the bag holds no poses."""
        return self.poses.position.shape[1] if len(self.poses) else 0

    def all_poses(self) -> PoseSeries:
        """Poses of the string's nodes at all samples of the run, read from the bag again."""
        series = PoseSeries()
        messages = (raw for _, raw, _ in self._messages.read((STRING_POSES,), SkippedMessages()))
        for raw in islice(messages, self._poses_before, self._poses_before + self.poses.seen):
            with suppress(MessageError):  # counted already
                series.add_message(raw)
        return series

    def shapes(self) -> Array:
        """Curves of the string along the hole [m] at the times of the poses, shape (T, k, 3), from the bit up."""
        return along_hole(self.scene, smooth(self.poses.position, self.poses.tangent))

    def centre_lines(self) -> ComplexArray:
        """Centre line z = x + i y at the marks [m], without the rotation of marks on the wall, shape (T, m)."""
        columns = [self.marks.names.index(place.name) for place in self.places]
        return centre_lines(self.places, self.marks.position[:, columns], self.marks.spin[:, columns])


def read_recording(path: str | Path, scene: Scene | None = None, selection: Selection | None = None) -> Recording:
    """Open and analyse a bag, or the bag in the folder of a run.

    Raises:
        BagError: Not a bag of this package, or nothing in it that could be analysed.
    """
    return Recording(open_bag(path, selection or Selection()), scene, selection)
