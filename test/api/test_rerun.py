# SPDX-License-Identifier: Apache-2.0
"""The commands of a bag computed again: the same frames without changes, other ones with them."""

import json
from dataclasses import replace

import numpy as np
import pytest

import drill_twin as dt
from drill_twin.cli import run_command
from drill_twin.core.errors import ArgumentError
from drill_twin.io.bag.metadata import contract_topic
from drill_twin.io.bag.reader import Bag
from drill_twin.io.bag.writer import BagWriter
from drill_twin.io.messages.rig_messages import CommandEncoder
from drill_twin.io.messages.topics import RIG_COMMAND, RIG_STATE, RPS_COMMAND, TWIN_SCENE, WOB_COMMAND
from drill_twin.scene.set_points import Command


@pytest.fixture
def part_of(tmp_path, bench_run):
    """A bag of the run with some of its topics, in a namespace, from a time on."""

    def write(*left_out, namespace="", begin=0.0, more=()):
        bag = Bag(bench_run.bag)
        topics = [topic for topic in bag.topics if topic not in left_out]
        named = dict.fromkeys([*topics, *(topic for topic, *_ in more)])
        folder = tmp_path / "bag_0"
        with BagWriter(
            folder, topics=[replace(contract_topic(topic), name=namespace + topic) for topic in named]
        ) as writer:
            for row in more:
                writer.write(*row)
            for topic, stamp, raw in bag.messages(topics):
                if stamp >= begin * 1e9 or topic == TWIN_SCENE:
                    writer.write(namespace + topic, stamp, raw)
        return folder

    return write


def test_without_changes_every_frame_comes_again_bit_for_bit(bench_run):
    both = dt.rerun(bench_run.bag)
    assert both.identical
    assert both.same_frames == 300
    assert both.largest_difference == 0.0
    assert both.commands.source == RIG_COMMAND
    np.testing.assert_array_equal(both.computed.marks.position, both.recorded.marks.position)


def test_other_numbers_give_other_frames_under_the_same_commands(bench_run):
    both = dt.rerun(bench_run.bag, {"effects.bow.amplitude": "4 mm"})
    assert not both.identical
    assert both.largest_difference > 1e-3
    np.testing.assert_array_equal(
        both.computed.set_points.weight_on_bit, both.recorded.set_points.weight_on_bit[: len(both.computed.set_points)]
    )
    rows = {name: values for name, *values in both.table()}
    assert rows["onset of whirl [s]"][0] != rows["onset of whirl [s]"][1]
    assert rows["hookload, mean [N]"][1].endswith(" %)")
    assert len(both.plot().axes) == len(both.recorded.marks.names) + 3


def test_a_bag_that_begins_late_is_run_from_the_start_of_its_scene(part_of):
    both = dt.rerun(part_of(begin=1.0))
    assert both.commands.known_from == pytest.approx(1.01)
    assert both.identical  # the commands before were those of the scene


def test_a_twin_in_a_namespace_is_run_again(part_of):
    assert dt.rerun(part_of(namespace="/rig2"), namespace="rig2").identical


def test_single_set_points_and_measured_states_are_used_where_there_are_no_commands(part_of, tmp_path):
    both = dt.rerun(part_of(RIG_COMMAND))
    assert both.commands.source == "/rig/state, as measured"
    final = both.recorded.rig.bit_force[-1]
    assert both.computed.rig.bit_force[-1] == pytest.approx(final, rel=0.05)
    (tmp_path / "bag_0").rename(tmp_path / "other_0")
    encoder, hand = CommandEncoder(), Command(30.0, 6.0)
    said = [(WOB_COMMAND, 0, encoder.wob_command(hand)), (RPS_COMMAND, 0, encoder.rps_command(hand))]
    both = dt.rerun(part_of(RIG_COMMAND, more=said))
    assert both.commands.source == "/rig/wob_command and /rig/rps_command"
    assert both.commands.commands[-1] == hand


@pytest.mark.parametrize("key", ["wob", "rig.rotation.value", "duration", "rig.block.value", "rig.block.shape"])
def test_set_points_are_those_of_the_bag(bench_run, key):
    with pytest.raises(dt.ArgumentError, match=f"{key}: expected a key that the bag does not decide"):
        dt.rerun(bench_run.bag, {key: "1"})


def test_a_bag_without_a_scene_needs_one_and_one_without_frames_is_refused(part_of, bench_scene, tmp_path):
    folder = part_of(TWIN_SCENE)
    with pytest.raises(dt.BagError, match="name the scene with --scene"):
        dt.rerun(folder)
    assert dt.rerun(folder, scene=bench_scene).identical
    folder.rename(tmp_path / "other_0")
    with pytest.raises(dt.BagError, match=f"expected frames on {RIG_STATE} to run again, found 0"):
        dt.rerun(part_of(RIG_STATE))


def test_the_command_writes_bag_figure_and_numbers(bench_run, tmp_path, capsys):
    again = tmp_path / "again"
    assert run_command(["rerun", str(bench_run.bag), "--out", str(again)]) == 0
    said = capsys.readouterr()
    assert "all 300 frames are the same, bit for bit" in said.out
    assert {file.name for file in again.iterdir()} == {"bag_0", "comparison.png", "rerun.json"}
    found = json.loads((again / "rerun.json").read_text("utf-8"))
    assert found["identical"]
    assert found["recorded"]["onset_s"] == found["computed"]["onset_s"] is not None
    assert run_command(["rerun", str(again), "--out", str(tmp_path / "third"), "--set", "rig.rotation.value=1"]) == 2
    assert "expected a key that the bag does not decide" in capsys.readouterr().err


def test_a_record_of_a_rig_is_run_on_the_string_named_with_another_weight(tmp_path):
    time = np.arange(0.0, 2.0, 0.05)
    rpm = np.where((time > 0.9) & (time < 1.2), np.nan, 60.0 + 10.0 * time)
    np.savetxt(tmp_path / "rig.csv", np.column_stack([time, 0.0 * time + 30.0, rpm]), delimiter=",",
               header="time [s],WOB [N],RPM [rpm]", comments="")  # fmt: skip
    with pytest.raises(ArgumentError, match="name it with --scene"):
        dt.rerun(tmp_path / "rig.csv")
    same = dt.rerun(tmp_path / "rig.csv", scene="pa6_bench")
    assert same.of_record
    assert same.commands.source.startswith("rig.csv: weight on bit and rotation")
    rig = same.computed.recording.rig
    assert rig.bit_force[-1] == pytest.approx(30.0)
    assert rig.top_drive_speed[100] == pytest.approx((60.0 + 10.0 * rig.time[100]) * np.pi / 30.0, rel=1e-3)
    other = dt.rerun(
        tmp_path / "rig.csv", {"rig.weight_on_bit": {"shape": "constant", "value": "50 N"}}, scene="pa6_bench"
    )
    assert other.commands.source.startswith("rig.csv: rotation,")
    assert other.computed.recording.rig.bit_force[-1] == pytest.approx(50.0)
