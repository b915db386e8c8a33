# SPDX-License-Identifier: Apache-2.0
"""Sensors over DDS: the simulator publishes its subs, the recorder finds their topics and records every message."""

import pytest

import drill_twin as dt
from drill_twin.report.summary import summarise

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
