# SPDX-License-Identifier: Apache-2.0
"""The demo, shortened: what it leaves, and that it fails when anything in it does."""

import json
import shutil
import signal
import sys

import pytest

from drill_twin.core.errors import RunError
from drill_twin.io.bag.reader import Bag
from drill_twin.io.messages.topics import OF_EVERY_RUN
from drill_twin.ros.demo import check_bag


@pytest.fixture
def demo(bench):
    def start(*arguments):
        command = [sys.executable, "-m", "drill_twin.ros", "demo", "--out", str(bench.folder / "demo"), *arguments]
        environment = {name: value for name, value in bench.environment.items() if name != "ROS_DOMAIN_ID"}
        bench.environment = environment
        return bench.command("demo", command)

    return start


def test_a_short_demo_leaves_bag_report_figures_and_summary_and_moves_an_older_one_aside(bench, demo):
    out = bench.folder / "demo"
    (out / "log").mkdir(parents=True)
    (out / "report.html").write_text("older", "utf-8")
    process = demo("--duration", "3", "--pace", "fast", "--replace")
    assert process.wait(150.0) == 0, process.text
    assert (bench.folder / "demo.old" / "report.html").read_text("utf-8") == "older"
    bag = Bag(out / "bag_0")
    assert not bag.truncated
    assert all(bag.topics[topic].count for topic in OF_EVERY_RUN)
    assert bag.topics["/rig/state"].count == 300
    summary = json.loads((out / "summary.json").read_text("utf-8"))
    wanted = {
        "onset_s", "whirl_frequency_hz", "whirl_ratio", "max_radius_m", "realtime_factor",
        "elements", "step_s", "effects", "seed", "version",
    }  # fmt: skip
    assert wanted <= set(summary)
    assert len(list(out.glob("*.png"))) >= 5
    assert (out / "report.html").stat().st_size > 100_000
    assert "Traceback" not in process.text
    # Once more: refused without --replace, and then nothing is lost.
    again = demo("--duration", "3")
    assert again.wait() == 2
    assert "expected a new or empty folder, found one with" in again.text
    assert (out / "summary.json").is_file()


def test_a_folder_that_is_not_a_demo_is_never_moved(bench, demo):
    out = bench.folder / "demo"
    out.mkdir()
    (out / "thesis.tex").write_text("precious", "utf-8")
    process = demo("--replace")
    assert process.wait() == 2
    assert (out / "thesis.tex").read_text("utf-8") == "precious"


def test_a_demo_whose_recorder_fails_fails_too(bench, demo):
    process = demo("--duration", "60")
    _started(bench, process)
    shutil.rmtree(bench.folder / "demo" / "bag_0")
    assert process.wait() == 1, process.text
    assert "found it removed; record again" in process.text
    assert "Traceback" not in process.text


def test_a_demo_that_is_interrupted_ends_its_nodes_in_order(bench, demo):
    process = demo("--duration", "60")
    _started(bench, process)
    process.send(signal.SIGINT)
    assert process.wait() == 1, process.text
    assert "stopped before it was over" in process.text
    assert not Bag(bench.folder / "demo" / "bag_0").truncated


@pytest.mark.long
def test_a_demo_that_is_killed_leaves_a_bag_that_can_be_read(bench, demo):
    process = demo("--duration", "60")
    _started(bench, process)
    process.kill()
    assert Bag(bench.folder / "demo" / "bag_0").topics["/rig/state"].count


def _started(bench, process):
    """Wait until the string moves."""
    bench.until(lambda: "rotation about" in process.text or process.code is not None, 150.0, "the string to move")
    assert process.code is None, process.text


def test_a_demo_with_an_unknown_scene_starts_nothing(bench, demo):
    process = demo("--scene", "no_such_scene")
    assert process.wait() == 2
    assert "no_such_scene" in process.text
    assert not (bench.folder / "demo").exists()


def test_a_domain_in_use_is_refused(bench):
    command = [sys.executable, "-m", "drill_twin.ros", "demo", "--out", str(bench.folder / "demo")]
    process = bench.command("demo", command)  # in the bench's own domain, which it has claimed
    assert process.wait() == 2
    assert f"ROS_DOMAIN_ID={bench.domain} is in use" in process.text


def test_a_bag_without_a_topic_is_not_good_enough(tmp_path):
    from drill_twin.io.bag.writer import BagWriter
    from drill_twin.io.messages.encode import encode_string

    with BagWriter(tmp_path / "bag_0") as bag:
        bag.write("/twin/scene", 1, encode_string("name: x"))
    with pytest.raises(RunError, match="found no message on /rig/command"):
        check_bag(tmp_path / "bag_0")
