# SPDX-License-Identifier: Apache-2.0
"""A recording is played in simulated time, at whatever speed it was recorded."""

import numpy as np

from drill_twin.io.messages.cdr import PoseArrayTemplate
from drill_twin.io.messages.encode import encode_string
from drill_twin.io.messages.topics import RIG_STATE, STRING_POSES, TWIN_SCENE
from drill_twin_dashboard.live.player import in_simulated_time

FRAME = 10_000_000  # ns


def _poses(stamp):
    return PoseArrayTemplate(1).fill(stamp, np.zeros((1, 3)), np.zeros((1, 4)))


def test_messages_get_the_time_of_the_frame_they_follow():
    """Recorded in lockstep, a hundred times as fast as it was simulated."""
    scene = encode_string("name: a")
    recorded = [(TWIN_SCENE, 5, scene)]
    for k in range(1, 4):
        recorded += [(STRING_POSES, 100 * k, _poses(k * FRAME)), (RIG_STATE, 100 * k + 1, b"")]
    times = [stamp for _, stamp, _ in in_simulated_time(recorded)]
    assert times == [FRAME, FRAME, FRAME, 2 * FRAME, 2 * FRAME, 3 * FRAME, 3 * FRAME]


def test_a_run_that_began_again_goes_on_in_time():
    stamps = [1, 2, 3, 1, 2]
    recorded = [(STRING_POSES, 7, _poses(k * FRAME)) for k in stamps]
    assert [stamp // FRAME for _, stamp, _ in in_simulated_time(recorded)] == [1, 2, 3, 3, 4]


def test_without_frames_the_time_of_the_recording_counts():
    recorded = [(RIG_STATE, 30, b""), (RIG_STATE, 50, b""), (STRING_POSES, 60, b"short")]
    assert list(in_simulated_time(recorded)) == recorded
