# SPDX-License-Identifier: Apache-2.0
"""A frame rate whose period is no whole number of nanoseconds: session, bag and nodes have the same bytes."""

import pytest

import drill_twin as dt
from drill_twin.io.messages.topics import MARKS_STATE, RIG_STATE, STRING_POSES

FRAMES = 24


@pytest.mark.long
@pytest.mark.parametrize("rate", [60.0, 300.0])
def test_nodes_in_lockstep_have_the_bytes_of_a_session(bench, payloads, tmp_path, rate):
    topics = (RIG_STATE, MARKS_STATE, STRING_POSES)
    over = f"numerics.frame_rate={rate:g} Hz; rig.weight_on_bit.duration=0.1 s; rig.rotation.duration=0.1 s"
    found = {topic: bench.collect(topic) for topic in topics}
    simulator = bench.start("simulator", pace="lockstep", overrides=over, duration=FRAMES / rate)
    driver = bench.start("rig_driver", wait_for="simulator test", overrides=over)
    bench.until(lambda: simulator.code is not None, what="the run to end")
    assert simulator.code == 0, bench.logs()
    assert driver.end() == 0, bench.logs()
    bench.drain()
    changes = dict(line.split("=") for line in over.split("; "))
    bag = dt.Simulation("pa6_bench", changes).run(FRAMES / rate).to_bag(tmp_path / "bag_0")
    for topic in topics:
        wanted = payloads(bag, topic)
        assert len(wanted) == FRAMES
        assert [bytes(raw)[: len(one)] for raw, one in zip(found[topic], wanted, strict=True)] == wanted, topic
    assert dt.rerun(bag).identical
