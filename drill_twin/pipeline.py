# SPDX-License-Identifier: Apache-2.0
"""From the topics of the twin to the findings about whirl: one path, for the analyzer node and for a bag.

Raw messages go in as they arrive or as they were recorded, whirl messages come out. Samples of the marks and of the
rig are paired by their stamps, so the findings do not depend on which of the two came first, nor on any clock: a bag
gives what the live analyzer gave, bit for bit.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from typing import Any

import numpy as np

from drill_twin.errors import DrillTwinError, MessageError
from drill_twin.messages.decode import JointState, JointStateReader, read_string
from drill_twin.messages.encode import MARK_AXES
from drill_twin.messages.topics import MARKS_STATE, RIG_STATE, TWIN_SCENE
from drill_twin.scene import Scene, parse_scene
from drill_twin.whirl import Analyzer, Findings, Summary
from drill_twin.wiring import FindingsEncoder, mark_infos

INPUTS = (TWIN_SCENE, MARKS_STATE, RIG_STATE)
"""Topics that the analysis needs."""
WAITING = 256
"""Samples of one topic that wait for their partner of the other, or for the scene."""

Message = tuple[str, bytes]


class WhirlPipeline:
    """Pairs marks and rig by stamp, analyses them, and encodes what is found.

    Attributes:
        scene: The scene that the marks belong to; None until it is known.
        findings: The latest findings; None before the first sample.
        malformed: Messages that could not be used.
        unpaired: Samples of one topic whose partner never came.
        trouble: What was wrong last, in words; empty while all is well.
        runs: How many runs have begun.
    """

    def __init__(self, scene: Scene | None = None) -> None:
        """With a `scene`, what comes on `/twin/scene` is not followed; without, each new text there begins a run."""
        self.scene: Scene | None = None
        self.findings: Findings | None = None
        self.malformed = self.unpaired = self.runs = 0
        self.trouble = ""
        self._given = scene
        self._text: str | None = None
        self._analyzer: Analyzer | None = None
        self._encoder: FindingsEncoder | None = None
        self._names: tuple[str, ...] = ()
        self._forget()
        if scene is not None:
            self._begin(scene)

    @property
    def onset_announced(self) -> bool:
        """Whether an onset has been found and encoded."""
        return self._encoder is not None and self._encoder.onset_announced

    def start(self) -> list[Message]:
        """What to publish before the first sample, where the scene was given; else nothing."""
        return [] if self._given is None or self._encoder is None else [self._encoder.before()]

    def take(self, topic: str, raw: bytes) -> list[Message]:
        """Take in one message and return topics and bytes that follow from it.

        Never raises for what is in a message: it counts it as `malformed` and says in `trouble` what was wrong.
        """
        try:
            if topic == MARKS_STATE:
                return self._on_marks(self._read_marks(raw))
            if topic == RIG_STATE:
                return self._on_rig(self._read_rig(raw))
            if topic == TWIN_SCENE and self._given is None:
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
        for stamp, marks, speed in waiting:
            messages += self._push(stamp, marks, speed)
        return messages

    def _begin(self, scene: Scene) -> list[Message]:
        marks = mark_infos(scene)
        self._analyzer = Analyzer(marks)
        self._encoder = FindingsEncoder(marks)
        self._names = tuple(f"{mark.name}/{axis}" for mark in marks for axis in MARK_AXES)
        self.scene, self.findings, self.trouble = scene, None, ""
        self.runs += 1
        return [self._encoder.before()]

    def _forget(self) -> None:
        self._read_marks, self._read_rig = JointStateReader().read, JointStateReader().read
        self._marks: dict[int, JointState] = {}
        self._speeds: dict[int, float] = {}
        self._before_scene: deque[tuple[int, JointState, float]] = deque(maxlen=WAITING)

    # --- samples --------------------------------------------------------------------------------------------------

    def _on_marks(self, state: JointState) -> list[Message]:
        self._marks[state.stamp] = state
        return self._join(state.stamp, self._marks)

    def _on_rig(self, state: JointState) -> list[Message]:
        drive = state.index("top_drive")
        if drive >= state.velocity.size:
            raise MessageError(f"expected the speed of top_drive on {RIG_STATE}, found no velocities")
        self._speeds[state.stamp] = float(state.velocity[drive])
        return self._join(state.stamp, self._speeds)

    def _join(self, stamp: int, waiting: dict[int, Any]) -> list[Message]:
        if stamp not in self._marks or stamp not in self._speeds:
            while len(waiting) > WAITING:
                waiting.pop(next(iter(waiting)))
                self.unpaired += 1
            return []
        return list(self._push(stamp, self._marks.pop(stamp), self._speeds.pop(stamp)))

    def _push(self, stamp: int, marks: JointState, speed: float) -> Iterator[Message]:
        if self._analyzer is None or self._encoder is None:
            self._before_scene.append((stamp, marks, speed))
            return
        if marks.names != self._names or not marks.position.size:
            self._refuse(
                f"expected the marks of the scene on {MARKS_STATE}, {', '.join(self._names)}, "
                f"found {', '.join(marks.names) or 'none'}{'' if marks.position.size else ', without positions'}"
            )
            return
        place = marks.position.reshape(-1, len(MARK_AXES))
        force = None
        if marks.effort.size:
            push = marks.effort.reshape(-1, len(MARK_AXES))
            force = np.hypot(push[:, 0], push[:, 1])
        self.findings = self._analyzer.push(stamp, place[:, :3], place[:, 3], speed, force)
        yield from self._encoder.messages(self.findings)
