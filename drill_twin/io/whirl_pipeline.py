# SPDX-License-Identifier: Apache-2.0
"""From the topics of the twin to the findings about whirl: one path, for the analyzer node and for a bag.

Raw messages go in as they arrive or as they were recorded, whirl messages come out. Samples of the marks and of the
rig are paired by their stamps, so the findings do not depend on which of the two came first, nor on any clock: a bag
gives what the live analyzer gave, bit for bit.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Collection, Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drill_twin.base.arrays import Array
from drill_twin.errors import DrillTwinError, MessageError
from drill_twin.io.adapters import FindingsEncoder, mark_infos
from drill_twin.io.messages.decode import JointState, JointStateReader, read_string
from drill_twin.io.messages.encode import MARK_AXES
from drill_twin.io.messages.topics import MARKS_STATE, RIG_STATE, TWIN_SCENE
from drill_twin.scene import Scene, parse_scene
from drill_twin.whirl import AnalysisError, Analyzer, BitMotion, BitOnlyAnalyzer, Findings, MarkInfo, Summary
from drill_twin.whirl.findings import Quality

INPUTS = (TWIN_SCENE, MARKS_STATE, RIG_STATE)
"""Topics that the analysis needs."""
WAITING = 256
"""Samples of one topic that wait for their partner of the other, or for the scene."""
STUCK = 200
"""So many samples in order, all before one already seen, are a run of their own; 1 to 2 s."""

Message = tuple[str, bytes]


Rig = tuple[float, float]
"""Speeds of the top drive and of the bit [rad/s]; nan where not known."""
UNKNOWN: Rig = (math.nan, math.nan)


class WhirlPipeline:
    """Pairs marks and rig by stamp, analyses them, and encodes what is found.

    Where a stream has no rig states, `lacks` them: the rotation then comes from the spin of the marks. Where it has no
    marks, whirl is not observable, and stick-slip of the bit is all that is found.

    Attributes:
        scene: The scene that the marks belong to; None until it is known.
        findings: The latest findings; None before the first sample.
        malformed: Messages that could not be used.
        unpaired: Samples of one topic whose partner never came.
        trouble: What was wrong last, in words; empty while all is well.
        runs: How many runs have begun.
        marks: The marks that are analysed.
        blind: What follows the bit where the scene or the stream has no marks; else None.
    """

    def __init__(
        self,
        scene: Scene | None = None,
        *,
        lacks: Collection[str] = (),
        marks: Sequence[str] = (),
        infos: Sequence[MarkInfo] = (),
    ) -> None:
        """Waits for the first message.

        Args:
            scene: The scene; what comes on `/twin/scene` is then not followed. Without, each new text begins a run.
            lacks: Topics that will not come: `/rig/state` or `/marks/state`.
            marks: Only these marks; all where none.
            infos: The marks themselves, where there is no scene to tell of them.

        Raises:
            AnalysisError: None of the marks of `scene` or `infos` has one of these names.
        """
        self.scene: Scene | None = None
        self.findings: Findings | None = None
        self.malformed = self.unpaired = self.runs = 0
        self.trouble = ""
        self._given = scene
        self._infos = tuple(infos)
        self._chosen = tuple(marks)
        self._without_rig, self._without_marks = RIG_STATE in lacks, MARKS_STATE in lacks
        self.blind = BitOnlyAnalyzer() if self._without_marks else None
        self._text: str | None = None
        self._analyzer: Analyzer | None = None
        self._encoder: FindingsEncoder | None = None
        self._layout: tuple[str, ...] = ()  # joints of the message that the columns are for
        self._columns = np.zeros((0, len(MARK_AXES)), np.intp)
        self.marks: tuple[MarkInfo, ...] = ()
        self._forget()
        if scene is not None or infos:
            self._begin(scene)

    @property
    def quality(self) -> Quality:
        """Counts of good and bad samples so far."""
        if self.blind is not None:
            return self.blind.quality
        return Quality() if self.findings is None else self.findings.quality

    @property
    def motion(self) -> str:
        """What the string is in now, in words; with stick-slip of the bit, if there is any."""
        if self.blind is not None:
            return f"whirl not observable, bit: {self.blind.bit.motion.value}"
        if self.findings is None:
            return "unknown"
        bit = self.findings.bit
        return f"{self.findings.motion.value}{', stick-slip of the bit' if bit is BitMotion.STICK_SLIP else ''}"

    @property
    def onset_announced(self) -> bool:
        """Whether an onset has been found and encoded."""
        return self._encoder is not None and self._encoder.onset_announced

    def start(self) -> list[Message]:
        """What to publish before the first sample, where the scene was given; else nothing."""
        given = self._given is not None or self._infos
        return [self._encoder.before()] if given and self._encoder is not None else []

    def take(self, topic: str, raw: bytes) -> list[Message]:
        """Take in one message and return topics and bytes that follow from it.

        Never raises for what is in a message: it counts it as `malformed` and says in `trouble` what was wrong.
        """
        try:
            if topic == MARKS_STATE:
                return self._on_marks(self._read_marks(raw))
            if topic == RIG_STATE:
                return self._on_rig(self._read_rig(raw))
            if topic == TWIN_SCENE and self._given is None and not self._infos:
                return self._on_scene(read_string(raw))
        except DrillTwinError as error:
            self._refuse(str(error))
        return []

    def _refuse(self, why: str) -> None:
        self.malformed += 1
        self.trouble = why

    def summary(self) -> Summary:
        """Findings of the whole run.

        Raises:
            DrillTwinError: No scene has come.
        """
        if self.blind is not None:
            return self.blind.summary()
        if self._analyzer is None:
            raise DrillTwinError(
                f"expected the scene of the run on {TWIN_SCENE}, found {self.trouble or 'none'}; name the scene"
            )
        return self._analyzer.summary()

    # --- scene ----------------------------------------------------------------------------------------------------

    def _on_scene(self, text: str) -> list[Message]:
        if text == self._text:  # the latched message once more
            return []
        scene = parse_scene(text, name=TWIN_SCENE)
        self._text = text
        if self.runs:  # what waits now belongs to the run before
            self._forget()
        waiting = list(self._before_scene)
        self._before_scene.clear()
        messages = self._begin(scene)
        for stamp, marks, rig in waiting:
            messages += self._push(stamp, marks, rig)
        return messages

    def _begin(self, scene: Scene | None) -> list[Message]:
        marks = picked(mark_infos(scene) if scene is not None else self._infos, self._chosen)
        self.marks = tuple(marks)
        self.blind = BitOnlyAnalyzer() if self._without_marks or not marks else None
        self._analyzer = None if self.blind is not None else Analyzer(marks)
        self._encoder = FindingsEncoder(marks)
        self._layout = ()
        self._newest = -1
        self._behind: list[tuple[int, JointState, Rig]] = []
        self.scene, self.findings, self.trouble = scene, None, ""
        self.runs += 1
        return [self._encoder.before()]

    def _forget(self) -> None:
        self._spin_known: bool | None = None
        self._read_marks, self._read_rig = JointStateReader().read, JointStateReader().read
        self._marks: dict[int, JointState] = {}
        self._rigs: dict[int, Rig] = {}
        self._before_scene: deque[tuple[int, JointState, Rig]] = deque(maxlen=WAITING)

    # --- samples --------------------------------------------------------------------------------------------------

    def _on_marks(self, state: JointState) -> list[Message]:
        if self.blind is not None:
            return []
        if self._without_rig:
            return list(self._push(state.stamp, state, UNKNOWN))
        self._marks[state.stamp] = state
        return self._join(state.stamp, self._marks)

    def _on_rig(self, state: JointState) -> list[Message]:
        rig = speeds(state)
        if self.blind is not None:
            changed = self.blind.push(state.stamp, *rig)
            return [FindingsEncoder.blind(state.stamp, self.blind.bit)] if changed else []
        self._rigs[state.stamp] = rig
        return self._join(state.stamp, self._rigs)

    def _join(self, stamp: int, waiting: dict[int, Any]) -> list[Message]:
        if stamp not in self._marks or stamp not in self._rigs:
            while len(waiting) > WAITING:
                waiting.pop(next(iter(waiting)))
                self.unpaired += 1
            return []
        return list(self._push(stamp, self._marks.pop(stamp), self._rigs.pop(stamp)))

    def _push(self, stamp: int, marks: JointState, rig: Rig) -> Iterator[Message]:
        """Raises MessageError where the message is not one of the marks that are analysed."""
        if self._analyzer is None or self._encoder is None:
            self._before_scene.append((stamp, marks, rig))
            return
        if marks.names != self._layout:
            self._columns = columns(marks.names, [mark.name for mark in self.marks])
            self._layout = marks.names
        if not marks.position.size:
            raise MessageError(f"expected positions on {MARKS_STATE}, found none")
        place = np.append(marks.position, np.nan)[self._columns]
        force = None
        if marks.effort.size:
            push = np.append(marks.effort, np.nan)[self._columns]
            force = np.hypot(push[:, 0], push[:, 1])
        self.findings = self._analyzer.push(stamp, place[:, :3], self._spin(place[:, 3]), rig[0], force, rig[1])
        yield from self._encoder.messages(self.findings)
        if self._is_stuck(stamp, marks, rig):
            yield from self._begin_again()

    def _is_stuck(self, stamp: int, marks: JointState, rig: Rig) -> bool:
        """Whether time has gone back for good: so many samples in order that are all before one already seen.

        Single ones are late and turned away. But after a stamp from the future, or a clock set back, nothing would ever
        count again.
        """
        if stamp >= self._newest:
            self._newest = stamp
            self._behind.clear()
            return False
        if self._behind and stamp <= self._behind[-1][0]:
            self._behind.clear()
        self._behind.append((stamp, marks, rig))
        return len(self._behind) >= STUCK

    def _begin_again(self) -> Iterator[Message]:
        behind = list(self._behind)
        yield from self._begin(self.scene)
        for sample in behind:
            yield from self._push(*sample)

    def _spin(self, spin: Array) -> Array | None:
        """The spin of the marks, or None in a stream that never had one."""
        if self._spin_known is None:
            self._spin_known = bool(np.isfinite(spin).any())
        return spin if self._spin_known else None


def speeds(state: JointState) -> Rig:
    """Speeds of the top drive and, where it is there, of the bit in a `/rig/state`.

    Raises:
        MessageError: There is no top drive, or it has no speed.
    """
    drive = state.index("top_drive")
    if drive >= state.velocity.size:
        raise MessageError(f"expected the speed of top_drive on {RIG_STATE}, found no velocities")
    bit = state.names.index("bit") if "bit" in state.names else state.velocity.size
    return float(state.velocity[drive]), float(state.velocity[bit]) if bit < state.velocity.size else math.nan


def columns(names: Sequence[str], marks: Sequence[str]) -> NDArray[np.intp]:
    """Places of x, y, z and spin of the marks among the joints of a `/marks/state`, shape (m, 4).

    A z or a spin that is not there gets the place after the last. Joints of other marks may be there too.

    Raises:
        MessageError: A mark has no x or no y.
    """
    places = {name: k for k, name in enumerate(names)}
    missing = [f"{mark}/{axis}" for mark in marks for axis in MARK_AXES[:2] if f"{mark}/{axis}" not in places]
    if missing:
        raise MessageError(
            f"expected the marks of the scene on {MARKS_STATE}, with {', '.join(missing)}, "
            f"found {', '.join(names) or 'none'}"
        )
    found = [[places.get(f"{mark}/{axis}", len(names)) for axis in MARK_AXES] for mark in marks]
    return np.array(found, np.intp)


def picked(marks: Sequence[MarkInfo], names: Sequence[str]) -> list[MarkInfo]:
    """The marks of these names, in the order of the string; all where there are none.

    Raises:
        AnalysisError: A name is not that of a mark.
    """
    known = [mark.name for mark in marks]
    strange = [name for name in names if name not in known]
    if strange:
        raise AnalysisError(f"expected marks of {', '.join(known)}, found {', '.join(strange)}; name some of these")
    return [mark for mark in marks if mark.name in names or not names]
