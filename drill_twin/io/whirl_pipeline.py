# SPDX-License-Identifier: Apache-2.0
"""Whirl analysis of raw messages, for the analyzer node and for a bag.

Samples of the marks and of the rig are paired by their stamps, so that the findings depend neither on the order of
arrival nor on a clock: a bag gives what the live analyzer gave, bit for bit.
"""

from collections import deque
from collections.abc import Collection, Iterator, Sequence

import numpy as np

from drill_twin.core.arrays import Array, ComplexArray
from drill_twin.core.errors import DrillTwinError, MessageError
from drill_twin.io.findings_encoder import FindingsEncoder
from drill_twin.io.messages.decode import JointStateReader, JointStates, read_float64, read_string
from drill_twin.io.messages.sensor_messages import ImuReading, read_imu
from drill_twin.io.messages.topics import FRAME_ID, MARKS_STATE, REALTIME_FACTOR, RIG_STATE, TWIN_SCENE
from drill_twin.io.samples import (
    FASTEST,
    UNKNOWN_RIG,
    WAITING,
    AnySample,
    RigSample,
    Sample,
    SampleOrder,
    SamplePairing,
    SampleRows,
    marks_in,
    read_marks,
    rig_of,
)
from drill_twin.io.scene_geometry import mark_infos, readings_topic, select_marks, sub_analyzer
from drill_twin.scene import Scene, parse_scene
from drill_twin.whirl import Analyzer, BitMotion, BitOnlyAnalyzer, Findings, MarkInfo, Summary
from drill_twin.whirl.downhole import SubAnalyzer
from drill_twin.whirl.findings import FoundRows, Quality
from drill_twin.whirl.marks import centre_lines

Message = tuple[str, bytes]
"""Topic and bytes."""


class WhirlPipeline:
    """Pairs marks and rig by stamp, analyses the samples, and encodes the findings.

    Where a stream has no rig states, `lacks` names them: the spin of the marks then gives the rotation. Where the
    stream has no marks, whirl is not observable, and only stick-slip of the bit is found. With the readings of a
    downhole `sub`, whirl and stick-slip of the sub's section are found.

    Attributes:
        scene, findings: The scene of the marks and the latest findings; None until there are any.
        malformed: Number of messages that could not be used; `trouble` is the last error, as text.
        runs, marks, encoder: Number of runs so far, the marks that are analysed, and the encoder of the findings.
        pairing: Samples of one topic that wait for their partner of the other, and the number of unpaired samples.
        bit_only: Analysis of the bit where the scene or the stream has no marks; else None.
    """

    def __init__(
        self,
        scene: Scene | None = None,
        *,
        lacks: Collection[str] = (),
        marks: Sequence[str] = (),
        infos: Sequence[MarkInfo] = (),
        sub: str = "",
        run: int = 0,
    ) -> None:
        """Start the analysis, or wait for a scene if neither `scene` nor `infos` is given.

        Args:
            scene: The scene; `/twin/scene` is then ignored. Without it, each new text there starts a run.
            lacks: Topics that the stream does not contain: `/rig/state` or `/marks/state`.
            marks: Names of the marks to analyse; all if empty.
            infos: The marks themselves, for a stream without a scene.
            sub: Name of a downhole sub whose readings are analysed instead of the marks, `measured/NAME` for a sub of a
                real rig.
            run: Number of the run, from 1, at whose end the analysis ends; later runs are only counted. 0: the last.

        Raises:
            AnalysisError: `marks` has a name that `scene` or `infos` has not, or `scene` does not list `sub`.
        """
        self.scene: Scene | None = None
        self.findings: Findings | None = None
        self.malformed = self.runs = 0
        self.trouble = ""
        self._given = scene
        self._infos = () if sub else tuple(infos)
        self._selected, self._run = tuple(marks), run
        self._without_rig, self._without_marks = RIG_STATE in lacks, MARKS_STATE in lacks
        self._sub, self._readings = sub, readings_topic(sub) if sub else ""
        self.bit_only = BitOnlyAnalyzer() if self._without_marks and not sub else None
        self._text = ""  # of the last good scene
        self._analyzer: Analyzer | SubAnalyzer | None = None
        self.encoder: FindingsEncoder | None = None
        self._names: tuple[str, ...] = ()
        self.pairing = SamplePairing()
        self.marks: tuple[MarkInfo, ...] = ()
        self._has_spin: bool | None = None  # of the first sample of the stream
        self._clear()
        if scene is not None or self._infos:
            self._start_run(scene)

    @property
    def over(self) -> bool:
        """True once the run whose findings are wanted has ended."""
        return 0 < self._run < self.runs

    @property
    def quality(self) -> Quality:
        """Counts of good and bad samples so far."""
        source = self.bit_only or self.section or self.findings
        return Quality() if source is None else source.quality

    @property
    def motion(self) -> str:
        """Present motion of the string as text, with stick-slip of the bit if there is any."""
        if self.bit_only is not None:
            return f"whirl not observable, bit: {self.bit_only.bit.motion.value}"
        if self.findings is None:
            return "unknown"
        bit = self.findings.bit
        return f"{self.findings.motion.value}{', stick-slip of the bit' if bit is BitMotion.STICK_SLIP else ''}"

    @property
    def section(self) -> SubAnalyzer | None:
        """Analysis of the section of a sub; None where marks are analysed."""
        return self._analyzer if isinstance(self._analyzer, SubAnalyzer) else None

    def start(self) -> list[Message]:
        """Messages to publish before the first sample, if the scene or the marks were given."""
        return [] if self.encoder is None else [self.encoder.no_onset()]

    def analyse(self, topic: str, raw: bytes) -> list[Message]:
        """Process one message and return the messages that follow; an error in it is counted, not raised."""
        try:
            if self._sub and topic in {self._readings, MARKS_STATE, RIG_STATE}:
                return list(self._analyse_sample(read_imu(raw))) if topic == self._readings else []
            if topic == MARKS_STATE:
                return self._on_marks(self._mark_states.read_one(raw))
            if topic == RIG_STATE:
                return self._on_rig(self._rig_states.read_one(raw))
            if topic == REALTIME_FACTOR and self.encoder is not None:
                self.encoder.summary.set_factor(read_float64(raw))
            if topic == TWIN_SCENE and self._given is None and not self._infos:
                return self._on_scene(read_string(raw))
        except DrillTwinError as error:
            self.malformed += 1
            self.trouble = str(error)
        return []

    def analyse_states(self, rig: JointStates, marks: JointStates | None) -> list[list[Message]] | None:
        """Process n states of rig and marks at once, as `analyse` would one after the other.

        Returns:
            The messages that follow each, without `/twin/summary`; None where they must be taken one by one.
        """
        try:
            found = rig_of(rig)
            if self.bit_only is not None and not self.over:
                return self._on_bit(self.bit_only, rig.stamps, found)
            if self._analyzer is None or self._without_rig or marks is None or marks.stamps != rig.stamps:
                return None
            return self.analyse_samples(read_marks(marks, self._names, found), summary=False)
        except MessageError:
            return None

    def analyse_samples(self, samples: SampleRows, *, summary: bool = True) -> list[list[Message]] | None:
        """As `analyse_states` for n samples; `summary`: with `/twin/summary`."""
        analyzer, stamps = self._analyzer, samples.stamps
        if not isinstance(analyzer, Analyzer) or self.over or self.pairing.waits or stamps[0] <= self._order.latest:
            return None
        if stamps != sorted(set(stamps)) or (np.abs(samples.rig[:, :2]) > FASTEST).any():
            return None
        messages = self._find(analyzer, samples, summary=summary)
        self._order.pass_by(stamps[-1])
        return messages

    def _find(self, analyzer: Analyzer, samples: SampleRows, *, summary: bool) -> list[list[Message]]:
        """Analyse samples, and encode what is found."""
        if self._has_spin is None:
            self._has_spin = bool(np.isfinite(samples.spin[0]).any())
        spin, (top_speed, bit_speed, *_) = samples.spin if self._has_spin else None, samples.rig.T
        found = analyzer.push_block(
            np.array(samples.stamps), samples.position, spin, top_speed, samples.wall_force, bit_speed
        )
        self.findings = analyzer.findings
        centres = centre_lines(self.marks, samples.position, samples.spin) if summary else None
        return self._encode(found, samples.frame_id, samples.rig if summary else None, centres)

    def _encode(
        self, found: FoundRows, frame_id: str, rig: Array | None, centres: ComplexArray | None = None
    ) -> list[list[Message]]:
        """Messages of the findings after each sample; an infinite value is counted as a malformed message."""
        try:
            return [] if self.encoder is None else self.encoder.rows(found, frame_id, rig, centres)
        except MessageError as error:
            self.malformed += 1
            self.trouble = str(error)
            return [[] for _ in found.stamps]

    def summary(self) -> Summary:
        """Findings of the whole run.

        Raises:
            DrillTwinError: There is no scene yet.
        """
        if (source := self.bit_only or self._analyzer) is None:
            raise DrillTwinError(
                f"expected the scene of the run on {TWIN_SCENE}, found {self.trouble or 'none'}; name the scene"
            )
        return source.summary()

    def _on_scene(self, text: str) -> list[Message]:
        if text == self._text:
            return []
        scene, self._text = parse_scene(text, name=TWIN_SCENE), text
        if self.runs:  # waiting samples belong to the run before
            self._clear()
        waiting = list(self._before_scene)
        self._before_scene.clear()
        return self._start_run(scene) + [message for sample in waiting for message in self._analyse_sample(sample)]

    def _start_run(self, scene: Scene | None) -> list[Message]:
        if 0 < self._run <= self.runs:
            self.runs += 1
            self._order = SampleOrder()
            return []
        if self._sub and scene is not None:
            self._analyzer = sub_analyzer(scene, self._sub)
            self.marks = (self._analyzer.mark,)
        else:
            infos = mark_infos(scene) if scene is not None else self._infos
            self.marks = tuple(select_marks(infos, self._selected))
            self.bit_only = BitOnlyAnalyzer() if self._without_marks or not self.marks else None
            self._analyzer = None if self.bit_only is not None else Analyzer(self.marks)
        self.encoder = FindingsEncoder(self.marks, scene.severity_bounds if scene else None)
        self._names = tuple(mark.name for mark in self.marks)
        self._order = SampleOrder()
        self.scene, self.findings, self.trouble = scene, None, ""
        self.runs += 1
        return [self.encoder.no_onset()]

    def _clear(self) -> None:
        """Discard waiting samples and what is known of the stream."""
        self._has_spin = None
        self._mark_states, self._rig_states = JointStateReader(), JointStateReader()
        self.pairing.clear()
        self._before_scene: deque[AnySample] = deque(maxlen=WAITING)

    def _on_marks(self, states: JointStates) -> list[Message]:
        if self.bit_only is not None:
            return []
        if self._analyzer is not None:
            marks_in(states, self._names)  # before the rig's state, its partner, comes
        (stamp,) = states.stamps
        sample = Sample(stamp, states) if self._without_rig else self.pairing.add(MARKS_STATE, stamp, states)
        return [] if sample is None else list(self._analyse_sample(sample))

    def _on_rig(self, states: JointStates) -> list[Message]:
        rig = rig_of(states)
        if self.bit_only is not None:
            return self._on_bit(self.bit_only, states.stamps, rig)[0]
        sample = self.pairing.add(RIG_STATE, states.stamps[0], rig)
        return [] if sample is None else list(self._analyse_sample(sample))

    def _on_bit(self, analyzer: BitOnlyAnalyzer, stamps: list[int], rigs: Array) -> list[list[Message]]:
        """Analyse the bit where whirl is not observable; messages that follow each of n states of the rig."""
        messages: list[list[Message]] = [[] for _ in stamps]
        for stamp, rig, sent in () if self.over else zip(stamps, rigs.tolist(), messages, strict=True):
            if analyzer.push(stamp, *rig[:2]):
                sent.append(FindingsEncoder.bit_only(stamp, analyzer.bit))
            if self.encoder is not None:
                sent.extend(self.encoder.bit_summary(stamp, analyzer.bit, RigSample(*rig)))
        return messages

    def _analyse_sample(self, sample: AnySample) -> Iterator[Message]:
        """Raise MessageError where the message is not of the marks that are analysed."""
        analyzer = self._analyzer
        if analyzer is None:
            self._before_scene.append(sample)
            return
        if self.over or (0 < self._run == self.runs and sample.stamp < self._order.latest):  # or of the next run
            pass
        elif isinstance(sample, Sample) and isinstance(analyzer, Analyzer):
            yield from self._find(analyzer, read_marks(sample.marks, self._names, sample.rig), summary=True)[0]
        elif isinstance(sample, ImuReading) and isinstance(analyzer, SubAnalyzer):
            self.findings = analyzer.push(sample.stamp, sample.values)
            prefix = sample.frame_id.rpartition(self._sub.rpartition("/")[2])[0]
            yield from self._encode(FoundRows.of(self.findings), prefix + FRAME_ID, UNKNOWN_RIG)[0]
        if behind := self._order.note(sample):
            yield from self._start_run(self.scene)
            for again in behind:
                yield from self._analyse_sample(again)
