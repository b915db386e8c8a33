# SPDX-License-Identifier: Apache-2.0
"""A run without ROS: everything is recorded, as the nodes would, and nothing is lost however it ends."""

import copy
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from one_frame import frames_of
from rosbags.rosbag2 import Reader

from drill_twin import __version__
from drill_twin.core.arrays import Array
from drill_twin.core.errors import BagError, MessageError, RunError
from drill_twin.dynamics.twin.frame_record import Record
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.io.bag.reader import Bag
from drill_twin.io.messages import topics
from drill_twin.io.messages.diagnostics import decode_diagnostics
from drill_twin.io.messages.encode import TwinEncoder
from drill_twin.io.messages.topics import OF_EVERY_RUN
from drill_twin.io.scene_geometry import string_geometry
from drill_twin.report.recording import read_recording
from drill_twin.runs import Session, SessionRun
from drill_twin.scene import parse_scene
from drill_twin.scene.set_points import Schedule

DETERMINED = (topics.RIG_COMMAND, topics.RIG_STATE, topics.MARKS_STATE, topics.STRING_POSES, topics.CLOCK_TOPIC,
              topics.STRING_MARKERS, topics.WHIRL_STATE, topics.WHIRL_MOTION, topics.WHIRL_ONSET,
              topics.COMMANDER)  # fmt: skip


def recorded(bag: Path, topic: str) -> list[bytes]:
    return [raw for _, _, raw in Bag(bag).messages((topic,))]


@pytest.fixture(scope="module")
def session(bench_scene):
    return Session(bench_scene)


def test_bag_is_whole_and_holds_every_topic_of_the_contract(bench_run):
    bag = Bag(bench_run.bag)
    assert not bag.truncated
    assert [name for name in OF_EVERY_RUN if not bag.topics[name].count] == []
    assert bag.topics[topics.MARKS_STATE].count == 300
    with Reader(bench_run.bag) as reader:  # what rosbag2 would check
        assert reader.message_count == bag.message_count


def test_frames_are_stamped_on_the_grid_of_the_frame_rate(bench_run):
    stamps = read_recording(bench_run.bag).marks.stamp
    assert (stamps == np.arange(1, 301) * 10_000_000).all()


def test_bytes_are_those_of_the_twin_stepped_by_hand(bench_run, bench_scene):
    twin, schedule = Twin(bench_scene), Schedule.from_scene(bench_scene)
    encoder = TwinEncoder(string_geometry(twin.scene, twin.rod.arc))
    marks, poses, rig = (
        recorded(bench_run.bag, topic) for topic in (topics.MARKS_STATE, topics.STRING_POSES, topics.RIG_STATE)
    )
    for k in range(120):
        frame = twin.advance(schedule.at((k + 1) / 100), 0.01)
        one = frames_of(frame)
        assert encoder.marks(one) + encoder.poses(one) + encoder.rig_state(one) == [marks[k], poses[k], rig[k]]


def test_commands_follow_the_schedule(bench_run, bench_scene):
    sent, schedule = read_recording(bench_run.bag).commands, Schedule.from_scene(bench_scene)
    wanted = [schedule.at(time) for time in sent.time]
    assert sent.weight_on_bit.tolist() == [command.weight_on_bit for command in wanted]
    assert sent.rotation.tolist() == [command.rotation for command in wanted]
    assert sent.weight_on_bit[-1] == pytest.approx(100.0)
    assert sent.rotation[-1] == pytest.approx(4.0 * math.pi)


def test_scene_on_the_bag_makes_it_self_describing(bench_run, bench_scene):
    text = Bag(bench_run.bag).scene()
    run = yaml.safe_load(text)["run"]
    assert parse_scene(text) == bench_scene
    assert run["version"] == __version__
    assert (run["elements"], run["seed"], run["pace"]) == (8, 1, "fast")
    assert run["effects"] == bench_scene.effect_names
    assert 0.0 < run["step_s"] <= 0.01
    assert run["started"].startswith("20")


def test_whirl_is_found_while_it_runs(bench_run):
    recording = read_recording(bench_run.bag)
    assert bench_run.summary.onset is not None
    announced = recording.live.onset
    assert announced == (pytest.approx(bench_run.summary.onset.time_s, abs=1e-9), bench_run.summary.onset.mark)
    assert (recording.live.messages, recording.live.differing) == (300, 0)
    radius = recording.whirl.orbit_radius
    assert radius.shape == (300, 4)
    assert np.nanmax(radius) > 0.05
    assert recorded(bench_run.bag, topics.WHIRL_ONSET)[0] != recorded(bench_run.bag, topics.WHIRL_ONSET)[-1]


def test_health_is_reported_each_second_with_the_cost(bench_run):
    reports = [decode_diagnostics(raw) for raw in recorded(bench_run.bag, topics.DIAGNOSTICS)]
    assert [stamp for stamp, _ in reports][:3] == [1_000_000_000, 2_000_000_000, 3_000_000_000]
    simulator = next(status for status in reports[-1][1] if status.name == "simulator")
    assert 0.0 < float(simulator.values["realtime_factor"]) <= float(simulator.values["physics_speed"])
    assert simulator.values["frames"] == "300"
    analyzer = next(status for status in reports[-1][1] if status.name == "analyzer")
    assert analyzer.values["severity"] in {"none", "low", "medium", "high", "severe"}


def test_same_scene_gives_the_same_bytes_again(session, bench_run, tmp_path):
    again = session.run(tmp_path / "bag_0")
    for topic in DETERMINED:
        assert recorded(again.bag, topic) == recorded(bench_run.bag, topic), topic


def test_stopped_run_leaves_a_whole_bag_of_what_was_simulated(session, tmp_path):
    seen = []
    outcome = session.run(tmp_path / "bag_0", progress=seen.append, stop=lambda: len(seen) == 2)
    frames = round(100 * outcome.simulated)
    assert not outcome.finished
    assert 2 <= frames <= 200
    bag = Bag(outcome.bag)
    assert not bag.truncated
    assert (outcome.bag / "metadata.yaml").exists()
    assert bag.topics[topics.MARKS_STATE].count == frames
    assert bag.topics[topics.DIAGNOSTICS].count == frames // 100 + 1
    assert [state.simulated for state in seen][-1] == outcome.simulated
    assert all(state.duration == 3.0 for state in seen)


def test_run_that_breaks_down_keeps_what_came_before(session, tmp_path, monkeypatch):
    fill, frames = Twin.fill, [50]

    def breaking(twin: Twin, record: Record, commands: Array, seconds: float):
        good = commands[: frames[0]]
        frames[0] -= len(good)
        found, _ = fill(twin, record, good, seconds)
        stopped = len(good) < len(commands)
        return found, RunError("the motion could not be followed past t = 0.5 s") if stopped else None

    monkeypatch.setattr(Twin, "fill", breaking)
    with pytest.raises(RunError, match=r"past t = 0\.5 s; what came before is recorded in .*bag_0"):
        session.run(tmp_path / "bag_0")
    bag = Bag(tmp_path / "bag_0")
    assert not bag.truncated
    assert bag.topics[topics.MARKS_STATE].count == 50
    assert bag.topics[topics.RIG_COMMAND].count == 51  # the driver sent that of the frame that failed


def test_set_points_that_fail_leave_the_frames_before(session, tmp_path):
    def weight(time: float) -> float:
        if time > 0.505:
            raise RuntimeError("no more set-points")
        return 10.0

    def not_a_number(time: float) -> float:
        return 10.0 if time < 0.505 else math.nan

    ready = copy.copy(session)
    for number, failing, error in ((0, weight, RuntimeError), (1, not_a_number, MessageError)):
        ready.schedule = replace(session.schedule, weight_on_bit=failing)
        with pytest.raises(error):
            ready.run(tmp_path / f"bag_{number}")
        assert Bag(tmp_path / f"bag_{number}").topics[topics.MARKS_STATE].count == 50


def test_frames_before_one_that_cannot_be_encoded_are_recorded(session, tmp_path, monkeypatch):
    fill, left = Twin.fill, [70]

    def broken(twin: Twin, record: Record, commands: Array, seconds: float):
        found, error = fill(twin, record, commands, seconds)
        if 0 <= left[0] < len(found.time):
            found.positions[left[0], 3] = math.inf
        left[0] -= len(found.time)
        return found, error

    monkeypatch.setattr(Twin, "fill", broken)
    with pytest.raises(MessageError, match="expected finite numbers"):
        session.run(tmp_path / "bag_0")
    assert len(recorded(tmp_path / "bag_0", topics.MARKS_STATE)) == 70


@pytest.mark.parametrize("frames", [1, 7, 256])
def test_the_size_of_the_blocks_does_not_change_a_byte(session, bench_run, tmp_path, monkeypatch, frames):
    monkeypatch.setattr(SessionRun, "most_frames", property(lambda run: min(frames, 100 - run.loop.frames % 100)))
    again = session.run(tmp_path / "bag_0")
    wanted, found = ([m for m in Bag(bag).messages() if m[0] in DETERMINED] for bag in (bench_run.bag, again.bag))
    assert found == wanted


def test_folder_that_exists_is_left_as_it_is(session, tmp_path):
    (tmp_path / "bag_0").mkdir()
    (tmp_path / "bag_0" / "precious.txt").write_text("mine")
    with pytest.raises(BagError, match="found a folder that exists"):
        session.run(tmp_path / "bag_0")
    assert [path.name for path in (tmp_path / "bag_0").iterdir()] == ["precious.txt"]
