# SPDX-License-Identifier: Apache-2.0
"""Analyzer node: onset and motion states of whirl from the marks and the rig, or from a downhole sub; live or replayed.

The node uses the stamps of the messages alone, so a replay gives the findings of the live run.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial
from typing import TYPE_CHECKING

from drill_twin.io.messages.diagnostics import Level, Status
from drill_twin.io.messages.topics import (
    DIAGNOSTICS,
    MARKS_STATE,
    REALTIME_FACTOR,
    RIG_STATE,
    TWIN_SCENE,
    TWIN_SUMMARY,
    WHIRL_MOTION,
    WHIRL_ONSET,
    WHIRL_STATE,
)
from drill_twin.ros.core.node import AUTOSTART, TwinNode
from drill_twin.ros.core.parameters import Parameter
from drill_twin.ros.core.policy import Rights

if TYPE_CHECKING:
    from drill_twin.io.whirl_pipeline import WhirlPipeline

_DEPTH = 1000  # messages; 5 s at 200 Hz
_QUIET = 0.1  # s


class Analyzer(TwinNode):
    """Joins marks and rig by stamp, analyses them, and publishes the findings."""

    NAME = "analyzer"
    PURPOSE = "Finds the onset of whirl, its precession, and the state of motion of every mark."
    PARAMETERS = (
        Parameter(
            "marks_scene",
            "",
            'scene that the marks belong to, by name or path, where none is on /twin/scene; "": the scene there',
        ),
        Parameter(
            "sub",
            "",
            "downhole sub whose readings are analysed instead of the marks, by its name in the scene; of a real rig "
            'measured/NAME; "": the marks',
            such_as="near_bit",
        ),
        AUTOSTART,
    )
    ON_CHANGE = (TWIN_SCENE,)
    RIGHTS = Rights(
        (
            *(DIAGNOSTICS, TWIN_SCENE, REALTIME_FACTOR, MARKS_STATE, RIG_STATE),
            *("/downhole/*/imu", "/measured/downhole/*/imu"),
        ),
    )
    _pipeline: WhirlPipeline
    """Pipeline of the analysis; made by `configure`."""

    def configure(self) -> None:
        """Create the pipeline, the publishers of its findings, and the subscriptions to scene and samples."""
        # Imported here: a bad parameter should be refused before.
        from drill_twin.io.scene_geometry import readings_topic
        from drill_twin.io.whirl_pipeline import WhirlPipeline
        from drill_twin.scene import load_scene

        scene = load_scene(self.settings.marks_scene) if self.settings.marks_scene else None
        pipeline = WhirlPipeline(scene, sub=self.settings.sub)
        samples = (readings_topic(self.settings.sub),) if self.settings.sub else (MARKS_STATE, RIG_STATE)
        self._sampled = samples[0]
        self._pipeline, self._counted, self._onset_logged, self._logged_problem = pipeline, (0, 0, 0), False, ""
        for topic in (WHIRL_STATE, WHIRL_MOTION, WHIRL_ONSET, TWIN_SUMMARY):
            self.topics.advertise(topic)
        self._publish(pipeline.start())
        self.topics.subscribe_scenes(partial(self._on_message, TWIN_SCENE))
        self.topics.subscribe_raw(REALTIME_FACTOR, partial(self._on_message, REALTIME_FACTOR))
        self._inputs = [
            self.topics.subscribe_raw(topic, partial(self._on_message, topic), depth=_DEPTH) for topic in samples
        ]
        if scene is None:
            self.samples.expect(TWIN_SCENE)
        self.samples.expect(*samples)

    def complete(self) -> None:
        """Analyse what has arrived already, and wait until the findings are received."""
        if hasattr(self, "_pipeline"):
            self.drain(_QUIET)
            self.publish_diagnostics()
            self.flush(2.0)

    def _on_message(self, topic: str, raw: bytes, *_: object) -> None:
        pipeline = self._pipeline
        runs, malformed = pipeline.runs, pipeline.malformed
        self._publish(pipeline.analyse(topic, raw))
        if pipeline.malformed > malformed:
            self.samples.unreadable(topic)
        self._count_samples(pipeline)
        if pipeline.runs != runs and pipeline.scene is not None:
            self._onset_logged = False
            self.samples.take(TWIN_SCENE)
            what = f"the sub {self.settings.sub}" if self.settings.sub else f"{len(pipeline.scene.string.marks)} marks"
            self.get_logger().info(f"analysing {what} of {pipeline.scene.name}")
        if pipeline.trouble != self._logged_problem:
            self._logged_problem = pipeline.trouble
            self.get_logger().error(self._logged_problem or "analysing again")
        onset = pipeline.findings.onset if pipeline.findings is not None else None
        if onset is not None and not self._onset_logged:
            self._onset_logged = True
            self.get_logger().info(f"whirl began at {onset.time_s:.2f} s at {onset.mark}: {onset.criterion}")

    def _count_samples(self, pipeline: WhirlPipeline) -> None:
        """Note what became of the sample that the last message has completed, if it has completed any."""
        quality, before = pipeline.quality, self._counted
        self._counted = quality.accepted, quality.incomplete, quality.late + quality.duplicate
        accepted, incomplete, out_of_order = (now > then for now, then in zip(self._counted, before, strict=True))
        if accepted or incomplete or out_of_order:
            sampled = self._sampled if pipeline.bit_only is None else RIG_STATE
            self.samples.take(sampled, finite=accepted or not incomplete, in_order=accepted)

    def _publish(self, messages: Iterable[tuple[str, bytes]]) -> None:
        for topic, raw in messages:
            self.topics.publish(topic, raw)

    # --- readiness and health -------------------------------------------------------------------------------------

    def not_ready(self) -> str:
        """Reason why it cannot analyse yet: no scene, or a topic without a connected publisher."""
        if self._pipeline.scene is None:
            return f"no scene on {TWIN_SCENE} yet"
        if self.topics.scenes.waits:
            return f"a scene on {TWIN_SCENE} waits to be read"
        late = [topic.topic_name for topic in self._inputs if not topic.get_publisher_count()]
        return f"not yet connected to the publishers of {', '.join(late)}" if late else ""

    def health(self) -> Status:
        """Counts of accepted and rejected samples, and the state of motion."""
        pipeline, quality = self._pipeline, self._pipeline.quality
        values = {
            "samples": str(quality.accepted),
            "duplicate": str(quality.duplicate),
            "late": str(quality.late),
            "incomplete": str(quality.incomplete),
            "unpaired": str(pipeline.pairing.unpaired),
            "malformed": str(pipeline.malformed),
            "runs": str(pipeline.runs),
            "scenes_put_off": str(self.topics.scenes.put_off),
            **self.samples.values(),
        }
        if pipeline.section is not None:
            sub = pipeline.section.sub
            values |= {"impacts": str(sub.impacts), "impact_rate": _known(sub.impact_rate_hz)}
            values |= {"largest_impact": _known(sub.largest_impact), "share_at_rest": _known(sub.share_at_rest)}
        silence = self.samples.verdict()
        loss = self.topics.loss if silence[0] is Level.OK else ""
        level, values["severity"] = pipeline.encoder.severity if pipeline.encoder else (Level.OK, "unknown")
        motion = level, f"motion: {pipeline.motion}"
        return self.status(values, (Level.ERROR, pipeline.trouble), (Level.WARN, loss), silence, motion)


def _known(value: float | None) -> str:
    return "" if value is None else f"{value:.4g}"
