# SPDX-License-Identifier: Apache-2.0
"""Findings from the readings of a sub: the same from its topic, from a bag without marks, and in Python."""

import json
import math

import numpy as np
import pytest
from summaries import summarise

import drill_twin as dt
from drill_twin.cli import run_command
from drill_twin.core.errors import DrillTwinError
from drill_twin.dynamics.sensors.sampling import Reading
from drill_twin.io.bag.virtual_bags import MemoryBag, copy_bag
from drill_twin.io.messages.encode import encode_string
from drill_twin.io.messages.sensor_messages import ImuEncoder
from drill_twin.io.messages.stamps import pack_stamp
from drill_twin.io.messages.topics import MARKS_STATE, TWIN_SCENE, WHIRL_ONSET, WHIRL_STATE
from drill_twin.io.messages.whirl_encode import decode_onset
from drill_twin.io.samples import STUCK
from drill_twin.io.whirl_pipeline import WhirlPipeline
from drill_twin.report.recording import Recording
from drill_twin.report.selection import Selection
from drill_twin.scene import load_scene, parse_scene
from drill_twin.whirl import AnalysisError

RATE, TURN, RADIUS = 100.0, math.tau * 2.0, 0.005
SUB = "{name: middle, distance_from_bit: 2500 mm, radius: 5 mm, rate: 100 Hz, accelerometer: {noise: 5 mm/s^2}}"


@pytest.fixture(scope="module")
def scene():
    return parse_scene(load_scene("pa6_bench").to_yaml(), name="x", overrides={"sensors.subs": f"[{SUB}]"})


@pytest.fixture(scope="module")
def readings():
    """A vertical string that turns, and from 12 s on whirls at 0.4 of the rotation."""
    time = (np.arange(2400) + 0.5) / RATE
    rate = 0.4 * TURN
    size = 0.04 / (1.0 + np.exp(-4.0 * (time - 12.0)))
    first = np.gradient(size, time)
    path = (np.gradient(first, time) + 2j * rate * first - rate**2 * size) * np.exp(1j * (rate - TURN) * time)
    zero = np.zeros_like(time)
    values = np.stack([path.real - RADIUS * TURN**2, path.imag, zero + 9.81, zero, zero, zero + TURN], -1)
    values += np.repeat([0.005, 0.0], 3) * np.random.default_rng(1).normal(size=values.shape)
    encoder = ImuEncoder("middle", 0.005, 0.0)
    return [encoder.encode(Reading(at, row)) for at, row in zip(time.tolist(), values, strict=True)]


@pytest.fixture(scope="module")
def bag(scene, readings):
    """A bag of a real rig, with the readings and nothing else but findings of the analyzer."""
    found, pipeline = MemoryBag(), WhirlPipeline(sub="measured/middle")
    messages = [(TWIN_SCENE, encode_string(scene.to_yaml()))]
    messages += [("/measured/downhole/middle/imu", raw) for raw in readings]
    for place, (topic, raw) in enumerate(messages):
        found.write(topic, place, raw)
        for name, message in pipeline.analyse(topic, raw):
            found.write(name, place, message)
    return found


def test_the_findings_on_topics_are_those_of_the_bag_and_of_python(bag):
    onsets = [decode_onset(raw) for _, _, raw in bag.messages([WHIRL_ONSET])]
    assert len(onsets) == 2
    result = dt.Result(bag)
    summary = summarise(result.recording)
    offline = result.whirl_from_sub("measured/middle")
    assert summary["live"]["messages"] == sum(1 for _ in bag.messages([WHIRL_STATE])) == 2400
    assert summary["live"]["differing"] == 0
    assert summary["onset_s"] == offline.onset_s == pytest.approx(onsets[1][1].time, abs=1e-6)
    assert summary["whirl_ratio"] == offline.whirl_ratio == pytest.approx(0.4, abs=0.01)
    crossing = 12.0 - math.log(0.04 / (0.05 * result.recording.places[0].clearance) - 1.0) / 4.0
    assert summary["onset_s"] == pytest.approx(crossing, abs=0.25)
    assert any("section of the sub measured/middle" in note for note in summary["notes"])


def test_analyze_takes_the_sub_of_a_bag_without_marks(bag, tmp_path, capsys):
    folder = copy_bag(bag, tmp_path / "rig_0")
    assert run_command(["analyze", str(folder), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["whirl_observable"]
    assert found["onset_mark"] == "middle"
    assert run_command(["report", str(folder), "--out", str(tmp_path / "report")]) == 0


def test_analyze_takes_a_sub_by_name_where_there_are_marks(bench_run):
    with pytest.raises(AnalysisError, match="one of none, found 'middle'"):
        Recording(dt.read_bag(bench_run.bag)._bag, load_scene("pa6_bench"), Selection(sub="middle"))


def test_a_name_that_no_sub_has_is_refused(scene):
    with pytest.raises(AnalysisError, match="one of middle, found 'top'"):
        WhirlPipeline(scene, sub="top")
    with pytest.raises(AnalysisError, match="the name of a sub"):
        WhirlPipeline(scene, sub="a/b")


def test_a_scene_without_the_sub_is_told_and_another_is_waited_for(scene, readings):
    pipeline = WhirlPipeline(sub="middle")
    bare = encode_string(load_scene("pa6_bench").to_yaml())
    assert pipeline.analyse(TWIN_SCENE, bare) == []
    assert "one of none" in pipeline.trouble
    assert pipeline.analyse("/downhole/middle/imu", readings[0]) == []
    found = pipeline.analyse(TWIN_SCENE, encode_string(scene.to_yaml()))
    assert {topic for topic, _ in found} >= {WHIRL_ONSET, WHIRL_STATE}
    assert pipeline.trouble == ""


def test_marks_are_not_analysed_and_a_clock_set_back_is_survived(scene, readings):
    pipeline = WhirlPipeline(scene, sub="middle")
    assert pipeline.analyse(MARKS_STATE, b"") == []
    future = bytearray(readings[0])
    pack_stamp(future, 4, 10**15)
    for raw in (bytes(future), *readings[: STUCK + 10]):
        pipeline.analyse("/downhole/middle/imu", raw)
    assert pipeline.runs == 2
    assert pipeline.quality.late == 0


def test_a_bag_with_a_sub_that_never_turned_says_so(scene, readings, tmp_path):
    bag = MemoryBag()
    bag.write(TWIN_SCENE, 0, encode_string(scene.to_yaml()))
    for place, raw in enumerate(readings[:50]):
        bag.write("/downhole/middle/imu", place, raw)
    with pytest.raises(DrillTwinError, match="revolutions of a sub"):
        summarise(Recording(bag))
