# SPDX-License-Identifier: Apache-2.0
"""Runs of the shipped scenes move as the reference values say; one taken up from a checkpoint gives the same bytes."""

import hashlib
import json
import tempfile
from pathlib import Path

import pytest
from one_frame import frames_of
from reference_values import DURATION, FILE, cases, differences, tolerances

from drill_twin.dynamics.twin.checkpoint import Checkpoint
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.io.bag.reader import Bag
from drill_twin.io.messages.encode import TwinEncoder
from drill_twin.io.messages.stamps import NANOSECONDS, seconds
from drill_twin.io.messages.topics import MARKS_STATE, RIG_STATE, STRING_POSES
from drill_twin.io.scene_geometry import string_geometry
from drill_twin.runs import Session
from drill_twin.scene.set_points import Schedule

KNOWN = json.loads(FILE.read_text("utf-8"))
HALF_A_SECOND = 0.5
QUICK = ("pa6_bench/lateral/least", "pa6_bench/spatial/own")
"""Each form, and each tolerance, once."""


def _scene(case, tolerance="own"):
    scene = cases(tolerances(tolerance)).get(case)
    if scene is None:
        pytest.skip("the record that the scene plays is not at hand")
    return scene


@pytest.mark.parametrize(
    "key", [key if key in QUICK else pytest.param(key, marks=pytest.mark.long) for key in sorted(KNOWN)]
)
def test_a_run_moves_as_before(key: str) -> None:
    case, _, tolerance = key.rpartition("/")
    assert differences(_scene(case, tolerance), tolerance, KNOWN[key]) == []


def test_the_values_hold_for_long_enough() -> None:
    assert min(reference["until"] for reference in KNOWN.values()) >= HALF_A_SECOND


def _bag_hashes(scene, topics):
    digests = {topic: hashlib.sha256() for topic in topics}
    with tempfile.TemporaryDirectory() as folder:
        outcome = Session(scene).run(Path(folder) / "bag_0")
        for topic, stamp, raw in Bag(outcome.bag).messages():
            if topic in digests:
                digests[topic].update(stamp.to_bytes(8, "little") + raw)
    return {topic: digest.hexdigest() for topic, digest in digests.items()}


def _hashes_with_checkpoint(scene):
    """Of frames one at a time, of a run that is put down half-way and taken up from a file."""
    schedule, twin = Schedule.from_scene(scene), Twin(scene)
    period = scene.numerics.frame_period_ns
    frames = round(DURATION * NANOSECONDS / period)
    encoder = TwinEncoder(string_geometry(twin.scene, twin.rod.arc))
    encoders = {RIG_STATE: encoder.rig_state, MARKS_STATE: encoder.marks, STRING_POSES: encoder.poses}
    digests = {topic: hashlib.sha256() for topic in encoders}
    for number in range(1, frames + 1):
        stamp = number * period
        command = schedule.at(seconds(stamp))
        frame = twin.advance(command, seconds(period))
        for topic, encode in encoders.items():
            digests[topic].update(stamp.to_bytes(8, "little") + encode(frames_of(frame))[0])
        if number == frames // 2:
            with tempfile.TemporaryDirectory() as folder:
                path = Path(folder) / "checkpoint.npz"
                Checkpoint.of(twin, command).save(path)
                twin = Checkpoint.load(path).twin()
    return {topic: digest.hexdigest() for topic, digest in digests.items()}


@pytest.mark.long
@pytest.mark.parametrize("case", sorted({key.rpartition("/")[0] for key in KNOWN}))
def test_frames_one_at_a_time_over_a_checkpoint_are_the_bytes_of_the_session(case: str) -> None:
    scene = _scene(case)
    parts = _hashes_with_checkpoint(scene)
    assert parts == _bag_hashes(scene, parts)
