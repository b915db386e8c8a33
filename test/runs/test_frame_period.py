# SPDX-License-Identifier: Apache-2.0
"""A frame rate whose period is no whole number of nanoseconds: the node's loop and a session have the same bytes."""

import pytest

import drill_twin as dt
from drill_twin.io.messages.stamps import seconds
from drill_twin.io.messages.topics import MARKS_STATE, RIG_STATE, STRING_POSES
from drill_twin.runs.loop import RunLoop
from drill_twin.scene.blocks.numerics import frame_period, frame_period_ns
from drill_twin.scene.set_points import Schedule

FRAMES = 24
SENT = (RIG_STATE, MARKS_STATE, STRING_POSES)


@pytest.mark.parametrize("rate", [60.0, 300.0])
def test_a_loop_frame_by_frame_has_the_bytes_of_a_session(rate):
    """As the simulator node drives it in lockstep, with the stamps of the rig driver."""
    over = {"numerics.frame_rate": rate, "rig.weight_on_bit.duration": "0.1 s", "rig.rotation.duration": "0.1 s"}
    session = dt.Simulation("pa6_bench", over)
    recorded = session.run(FRAMES / rate).recording.bag.messages(SENT)
    found: list[tuple[str, bytes]] = []
    loop = RunLoop(session.scene, frame_period(rate), lambda topic, raw: found.append((topic, bytes(raw))))
    plan = Schedule.from_scene(session.scene)
    for frame in range(1, FRAMES + 1):
        loop.advance(plan.at(seconds(frame * frame_period_ns(rate))))
    wanted = [(topic, bytes(raw)) for topic, _, raw in recorded]
    assert [message for message in found if message[0] in SENT] == wanted
    assert len(wanted) == len(SENT) * FRAMES


def test_a_period_is_whole_nanoseconds_and_that_of_its_own_rate():
    for rate in (1.0, 23.976, 60.0, 100.0, 300.0, 999.0, 2000.0):
        period = frame_period_ns(rate)
        assert abs(period * rate - 1e9) <= 0.5 * rate
        assert frame_period_ns(1e9 / period) == period
        assert frame_period(rate) * 1e9 == pytest.approx(period, rel=1e-15)
