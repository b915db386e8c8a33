# SPDX-License-Identifier: Apache-2.0
"""Adapters between scene, twin, analysis and messages, shared by the nodes and the run without ROS.

Both use these functions only, so that their bags are the same.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from datetime import UTC, datetime

import yaml

from drill_twin import __version__
from drill_twin.discretisation.discretise import survey_of
from drill_twin.io.messages.geometry import StringGeometry
from drill_twin.io.messages.stamps import NANOSECONDS
from drill_twin.io.messages.topics import WHIRL_MOTION, WHIRL_ONSET, WHIRL_STATE
from drill_twin.io.messages.whirl_encode import (
    STRING_LEVEL,
    Motion,
    OnsetMessage,
    WhirlStateEncoder,
    encode_motion,
    encode_onset,
)
from drill_twin.scene import Scene
from drill_twin.twin.twin import Twin
from drill_twin.whirl import BitMotion, MarkInfo, StickSlip
from drill_twin.whirl.bit_only_analyzer import NOT_OBSERVABLE
from drill_twin.whirl.findings import Findings

BIT = "bit"
"""Name under which `/whirl/motion` reports the rotation of the bit: steady, torsional vibration, stick-slip."""


def string_geometry(twin: Twin) -> StringGeometry:
    """Geometry of the string for the markers in RViz and Foxglove."""
    scene = twin.scene
    line = survey_of(scene)
    marks = scene.string.marks
    return StringGeometry(
        node_count=twin.elements + 1,
        mark_names=tuple(mark.name for mark in marks),
        mark_distances=tuple(mark.distance_from_bit for mark in marks),
        length=scene.length,
        outer_radius=max(0.5 * section.outer_diameter for section in scene.string.sections),
        hole_radius=scene.hole.radius,
        node_distances=twin.rod.arc,
        axis_at=None if line is None else line.at,
    )


def mark_infos(scene: Scene) -> list[MarkInfo]:
    """Marks of a scene for the whirl analysis."""
    return [
        MarkInfo(
            name=mark.name,
            distance_from_bit=mark.distance_from_bit,
            on=mark.on,
            wall_offset=scene.outer_radius_at(mark.distance_from_bit),
            clearance=scene.clearance_at(mark.distance_from_bit),
        )
        for mark in scene.string.marks
    ]


def describe_run(twin: Twin, pace: str = "fast") -> str:
    """Text of `/twin/scene`: the resolved scene (YAML) with a `run` block of version, seed, resolution and effects.

    Args:
        twin: The twin.
        pace: Pace of the run: realtime, fast or lockstep.
    """
    run = {
        "version": __version__,
        "seed": int(twin.scene.numerics.seed),
        "elements": int(twin.elements),
        "step_s": float(twin.step_size),
        "effects": [str(name) for name in twin.effects],
        "pace": pace,
        "started": datetime.now(UTC).isoformat(timespec="milliseconds"),
    }
    return f"{twin.scene.to_yaml().rstrip()}\n{yaml.safe_dump({'run': run}, sort_keys=False)}"


class FindingsEncoder:
    """Encodes findings: `/whirl/state` for each, `/whirl/motion` on change and once a simulated second."""

    def __init__(self, marks: Sequence[MarkInfo]) -> None:
        self._state = WhirlStateEncoder([mark.name for mark in marks])
        self._motion: tuple[object, ...] = ()
        self._motion_due = -1
        self.onset_announced = False
        """True once an onset was encoded."""

    @staticmethod
    def no_onset(stamp: int = 0) -> tuple[str, bytes]:
        """Topic and bytes of `/whirl/onset` without an onset, to publish before the first sample."""
        return WHIRL_ONSET, encode_onset(stamp, None)

    @staticmethod
    def bit_only(stamp: int, bit: StickSlip) -> tuple[str, bytes]:
        """Topic and bytes of `/whirl/motion` for a stream without marks."""
        whirl = Motion(STRING_LEVEL, BitMotion.UNKNOWN.value, NOT_OBSERVABLE)
        return WHIRL_MOTION, encode_motion(stamp, [whirl, Motion(BIT, bit.motion.value, bit.criterion)])

    def messages(self, findings: Findings) -> Iterator[tuple[str, bytes]]:
        """Topics and bytes of the messages for these findings."""
        stamp = findings.stamp_ns
        yield (
            WHIRL_STATE,
            self._state.encode(stamp, findings.orbit_radius, findings.precession, findings.ratio, findings.confidence),
        )
        motion = (findings.motion, findings.bit, *findings.state)
        if motion != self._motion or stamp >= self._motion_due:
            self._motion, self._motion_due = motion, stamp - stamp % NANOSECONDS + NANOSECONDS
            yield WHIRL_MOTION, encode_motion(stamp, _motions(findings))
        if findings.onset is not None and not self.onset_announced:
            self.onset_announced = True
            onset = findings.onset
            yield WHIRL_ONSET, encode_onset(stamp, OnsetMessage(onset.time_s, onset.mark, onset.confidence))


def _motions(findings: Findings) -> list[Motion]:
    marks = zip(findings.marks, findings.state, findings.criterion, strict=True)
    return [
        Motion(STRING_LEVEL, findings.motion.value, findings.motion_criterion),
        *(Motion(mark, state.value, criterion) for mark, state, criterion in marks),
        Motion(BIT, findings.bit.value, findings.bit_criterion),
    ]
