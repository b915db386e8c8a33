# SPDX-License-Identifier: Apache-2.0
"""Sensors over DDS: the simulator publishes its subs, the recorder finds their topics and records every message."""

import pytest
from summaries import summarise

import drill_twin as dt
from drill_twin.io.messages.topics import RIG_STATE, SURFACE_STATE, TOPICS, WHIRL_STATE, imu_topic, summary_topic
from drill_twin.io.messages.type_store import deserialize

SCENE = """
base: pa6_bench
sensors:
  subs:
    - {name: low, distance_from_bit: 500 mm, radius: 5 mm, rate: 100 Hz}
  surface: {rate: 10 Hz}
"""


@pytest.mark.long
def test_the_analyzer_takes_a_sub_and_finds_what_its_bag_gives(bench, tmp_path):
    file = bench.folder / "rig.yaml"
    file.write_text(f"{SCENE}\nrig:\n  rotation: {{shape: ramp, value: 4 rev/s, duration: 0.2 s}}\n", "utf-8")
    simulator = bench.start("simulator", pace="lockstep", scene=str(file), duration=4)
    others = [bench.start("analyzer", sub="low"), bench.start("recorder", bag=str(tmp_path / "bag_0"))]
    bench.start("rig_driver", scene=str(file), wait_for="simulator analyzer recorder")
    bench.until(lambda: simulator.code is not None, 120.0, "the run to end")
    assert [process.end() for process in others] == [0, 0], bench.logs()
    result = dt.read_bag(tmp_path / "bag_0", sub="low")
    live = summarise(result.recording)["live"]
    assert (live["messages"], live["differing"]) == (400, 0)
    assert result.recording.summary.quality.accepted > 200
    assert result.whirl_from_sub("low").to_dict() == result.recording.summary.to_dict()


def test_every_frame_has_the_prefix(bench):
    """Of the sensors, and of what an analyzer finds from a sub; bit, marks and subs: `test_transforms.py`."""
    file = bench.folder / "rig.yaml"
    file.write_text(f"{SCENE}\nrig:\n  rotation: {{shape: ramp, value: 4 rev/s, duration: 0.2 s}}\n", "utf-8")
    topics = (RIG_STATE, SURFACE_STATE, imu_topic("low"), summary_topic("low"), WHIRL_STATE)
    heard = {topic: bench.collect(topic) for topic in topics}
    simulator = bench.start("simulator", scene=str(file), frame_prefix="rig2/", pace="fast", duration=4)
    bench.start("analyzer", sub="low")
    bench.start("rig_driver", scene=str(file), wait_for="simulator analyzer")
    bench.until(lambda: simulator.code is not None, what="the run to end")
    bench.drain()
    frames = {topic: {deserialize(raw, TOPICS[topic].type_name).header.frame_id for raw in heard[topic]}
              for topic in topics}  # fmt: skip
    assert frames == {topic: {"rig2/low" if topic.startswith("/downhole") else "rig2/hole"} for topic in topics}


@pytest.mark.long
def test_a_recorded_run_has_every_reading(bench, tmp_path):
    file = bench.folder / "rig.yaml"
    file.write_text(SCENE, "utf-8")
    simulator = bench.start("simulator", pace="lockstep", scene=str(file), duration=1.5)
    others = [bench.start("analyzer"), bench.start("recorder", bag=str(tmp_path / "bag_0"))]
    bench.start("rig_driver", scene=str(file), wait_for="simulator analyzer recorder")
    bench.until(lambda: simulator.code is not None, 120.0, "the run to end")
    assert [process.end() for process in others] == [0, 0], bench.logs()
    result = dt.read_bag(tmp_path / "bag_0")
    low = result.measured.subs["low"]
    assert low.imu.stamp.tolist() == [10_000_000 * k + 5_000_000 for k in range(150)]
    assert len(low.summary) == 2
    assert len(result.measured.surface) == 15
