# SPDX-License-Identifier: Apache-2.0
"""Bad input: a node that cannot start says why in one line and ends with exit code 2."""

import signal
import sys

import pytest

from drill_twin.io.messages.diagnostics import Level
from drill_twin.ros.entry_points import start


@pytest.fixture
def refusal(bench, monkeypatch, capfd):
    """Start a node in this process, in the bench's domain; returns what it printed as its error."""
    for name in ("ROS_DOMAIN_ID", "ROS_LOG_DIR"):
        monkeypatch.setenv(name, bench.environment[name])
    handlers = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}

    def refuse(node, *arguments):
        capfd.readouterr()
        code = start(node, list(arguments))
        error = capfd.readouterr().err
        assert code == 2, error
        lines = [line for line in error.splitlines() if line.startswith(f"{node}: error: ")]
        assert len(lines) == 1, error
        assert "Traceback" not in error
        return lines[0].removeprefix(f"{node}: error: ")

    yield refuse
    for number, handler in handlers.items():
        signal.signal(number, handler)


def _set(**parameters):
    return ["--ros-args", *(part for name, value in parameters.items() for part in ("-p", f"{name}:={value}"))]


@pytest.mark.parametrize(
    ("node", "parameters", "words"),
    [
        ("simulator", {"frame_rate": "-5.0"}, ["frame_rate", "0 to 1000 [Hz]", "-5.0"]),
        ("simulator", {"frame_rate": ".nan"}, ["frame_rate", "nan"]),
        ("simulator", {"frame_rate": "fast"}, ["frame_rate", "a frequency", '"fast"']),
        ("simulator", {"pace": "warp"}, ["pace", "realtime, fast, lockstep", "'warp'"]),
        ("simulator", {"wait_for_command": "3"}, ["wait_for_command", "true or false", "3"]),
        ("simulator", {"fram_rate": "100.0"}, ["fram_rate", "did you mean frame_rate"]),
        ("simulator", {"overrides": "'hole.radius 80 mm'"}, ["overrides", "KEY=VALUE", "hole.radius 80 mm"]),
        ("simulator", {"overrides": "'hole.radius=80 kg'"}, ["hole.radius", "length", "80 kg"]),
        ("simulator", {"scene": "no_such_scene"}, ["no_such_scene", "pa6_bench"]),
        ("rig_driver", {"scene": "no_such_scene"}, ["no_such_scene", "pa6_bench"]),
        ("rig_driver", {"wob": "'40 rpm'"}, ["rig.weight_on_bit.value", "40 rpm"]),
        ("rig_driver", {"rpm": "120"}, ["rpm", 'a text with a unit such as "120 rpm"', "found 120 without a unit"]),
        ("rig_driver", {"rpm": "'120'"}, ["rpm", "found '120' without a unit"]),
        ("simulator", {"max_speed": "12.0"}, ["max_speed", "0 to 628.319 [rad/s]", "found 12.0 without a unit"]),
        ("simulator", {"max_speed": "12 N"}, ["max_speed", "a speed of rotation", "12 N"]),
        ("simulator", {"max_speed": "7000 rpm"}, ["max_speed", "0 to 628.319 [rad/s]", "7000 rpm"]),
        ("simulator", {"command_timeout": "10 ms"}, ["command_timeout", "0.05 to 3600 [s]", "10 ms"]),
        ("rig_driver", {"at_end": "explode"}, ["at_end", "hold, stop"]),
        ("rig_driver", {"table": "/no/such/table.csv"}, ["/no/such/table.csv"]),
        ("analyzer", {"marks_scene": "no_such_scene"}, ["no_such_scene"]),
        ("recorder", {"topics": "[/camera/image]"}, ["topics", "/rig/command", "/camera/image"]),
        ("recorder", {"topics": "[/tf]"}, ["expected topics whose messages are installed", "/tf", "tf2_msgs"]),
        ("recorder", {"exclude_topics": "[/rig/stat]"}, ["exclude_topics", "/rig/state", "/rig/stat"]),
        ("recorder", {"regex": "'/rig('"}, ["regex", "expected a regular expression", "/rig("]),
        ("recorder", {"exclude_regex": "/"}, ["exclude_regex", "found none that all four let pass"]),
        ("recorder", {"topics": "[1, 2]"}, ["topics", 'a list of texts such as ["/rig/state"', "[1, 2]"]),
        ("recorder", {"bag": "/proc/no/bag_0"}, ["/proc/no/bag_0"]),
        ("replayer", {}, ["bag", "expected the path of a bag"]),
        ("replayer", {"bag": "/no/such/bag"}, ["/no/such/bag"]),
        ("replayer", {"bag": "x", "rate": "-1.0"}, ["rate", "0 to 1000"]),
        ("twin", {"pace": "warp"}, ["pace", "'warp'"]),
        ("twin", {"spend": "1"}, ["spend", "none of that name"]),
    ],
)
def test_a_bad_parameter_refuses_to_start(refusal, node, parameters, words):
    said = refusal(node, *_set(**parameters))
    for word in words:
        assert word in said


def test_a_whole_number_will_do_where_a_number_is_wanted(bench):
    process = bench.start("simulator", wait_for_command=False, duration=1, pace="fast")
    assert process.wait() == 0, process.text


def test_other_arguments_are_refused(refusal):
    assert "--fast" in refusal("simulator", "--fast")
    assert "write -p NAME:=VALUE" in refusal("simulator", "--ros-args", "-p", "scene")
    # ROS itself would take it for a renaming, and run another scene than the one that was meant.
    assert "write --ros-args -p scene:=two_mass" in refusal("simulator", "scene:=two_mass")
    assert "write -p scene:=two_mass" in refusal("simulator", "--ros-args", "scene:=two_mass")
    assert "no_such_file.yaml" in refusal("simulator", "--ros-args", "--params-file", "no_such_file.yaml")


def test_a_malformed_parameter_file_is_refused(refusal, tmp_path):
    file = tmp_path / "parameters.yaml"
    file.write_text("/**:\n  ros__parameters:\n   scene: [pa6\n", "utf-8")
    assert "ROS arguments" in refusal("simulator", "--ros-args", "--params-file", str(file))


@pytest.mark.parametrize("domain", ["233", "-1", "one"])
def test_a_domain_that_is_none_is_refused(refusal, monkeypatch, domain):
    monkeypatch.setenv("ROS_DOMAIN_ID", domain)
    assert "ROS_DOMAIN_ID: expected a whole number from 0 to 232" in refusal("analyzer")


def test_an_existing_bag_is_refused_and_left_alone(refusal, tmp_path):
    (tmp_path / "bag_0").mkdir()
    (tmp_path / "bag_0" / "precious").write_text("data", "utf-8")
    assert "exists" in refusal("recorder", *_set(bag=tmp_path / "bag_0"))
    assert (tmp_path / "bag_0" / "precious").read_text("utf-8") == "data"


def test_a_malformed_scene_names_file_and_line(refusal, tmp_path):
    file = tmp_path / "mine.yaml"
    file.write_text("name: mine\nhole:\n  radius: 90 kg\n", "utf-8")
    assert f"{file}:3" in refusal("simulator", *_set(scene=file))


def test_a_table_with_wrong_columns_lists_what_is_there(refusal, tmp_path):
    table = tmp_path / "table.csv"
    table.write_text("alpha,beta\n0,1\n1,2\n", "utf-8")
    said = refusal("rig_driver", *_set(table=table))
    assert "alpha" in said
    assert "beta" in said


def test_a_replay_of_no_topic_is_refused(refusal, small_bag):
    said = refusal("replayer", *_set(bag=small_bag, topics="/advice/state", loop="true"))
    assert "expected them to leave a topic of the bag, " in said
    assert 'found topics "/advice/state" and leave_out ""' in said
    assert "expected a place in the bag" in refusal("replayer", *_set(bag=small_bag, start_offset="1e6"))


def test_what_is_not_a_bag_is_refused(refusal, tmp_path):
    file = tmp_path / "bag_0.mcap"
    file.write_bytes(b"not a bag at all")
    assert str(file) in refusal("replayer", *_set(bag=file))


@pytest.mark.fault("a second simulator in the domain", "it refuses to start; the first one runs on")
def test_a_second_simulator_in_a_domain_is_refused(bench):
    first = bench.start("simulator", wait_for_command=False)
    bench.until_ready("simulator")
    second = bench.start("simulator")
    assert second.wait() == 2, second.text
    assert "expected to be the only simulator" in second.text
    assert "publishers of /string/poses: /simulator, in ROS_DOMAIN_ID" in second.text
    bench.until_status("simulator", bool)
    assert {status.level for status in bench.history if status.values.get("simulated_time")} <= {Level.OK, Level.WARN}
    assert first.code is None
    assert first.end() == 0


@pytest.mark.parametrize("node", ["simulator", "rig_driver", "analyzer", "advisor", "recorder", "replayer", "twin"])
def test_help_names_every_parameter_with_its_unit(node, capsys):
    assert start(node, ["--help"]) == 0
    said = capsys.readouterr().out
    assert said.startswith(f"usage: {node} ")
    assert "parameters:" in said


def test_an_unknown_node_is_refused(bench):
    process = bench.command("nodes", [sys.executable, "-m", "drill_twin.ros", "driller"])
    assert process.wait() == 2
    assert "driller: error: expected one of simulator, " in process.text


@pytest.mark.parametrize("program", ["analyzer", "demo"])
def test_without_rclpy_a_program_says_what_to_do(bench, program):
    # An interpreter that finds this package and its libraries, but no rclpy: as after pip install without ROS.
    start = f"from drill_twin.ros.entry_points import start; sys.exit(start({program!r}, []))"
    hide = f"import sys; sys.modules['rclpy'] = None; {start}"
    process = bench.command(program, [sys.executable, "-c", hide])
    assert process.wait() == 2
    assert "source /opt/ros/jazzy/setup.bash" in process.text
    assert "Traceback" not in process.text
