# SPDX-License-Identifier: Apache-2.0
"""A run held in hand over DDS: pause, step, resume, reset, checkpoints, and a simulator that is killed and goes on."""

import math
import signal
import zipfile

import pytest
from std_srvs.srv import Trigger

from drill_twin.io.messages.decode import read_clock
from drill_twin.io.messages.rig_messages import CommandEncoder
from drill_twin.io.messages.topics import CLOCK_TOPIC, RIG_COMMAND, RIG_STATE, STRING_POSES, TWIN_SCENE
from drill_twin.scene.set_points import Command

FRAME = 10_000_000  # ns


def _do(bench, action):
    answer = bench.call(f"/simulator/{action}")
    return answer.success, answer.message


def _frames(bench):
    """Numbers of the frames whose clocks have come."""
    return [stamp // FRAME for raw in bench.clocks if (stamp := read_clock(bytes(raw)))]


@pytest.fixture
def running(bench):
    """A simulator that runs by itself at 40 N and 2 rev/s, with a checkpoint file."""
    bench.file, bench.saved = bench.folder / "run.npz", bench.folder / "run_saved.npz"
    bench.clocks, bench.scenes = bench.collect(CLOCK_TOPIC), bench.collect(TWIN_SCENE, latched=True)
    process = bench.start("simulator", checkpoint=str(bench.file), checkpoint_period=0.0, command_timeout=3600.0)
    bench.until_ready("simulator")
    bench.publisher(RIG_COMMAND).publish(CommandEncoder().command(0, Command(40.0, 4.0 * math.pi)))
    bench.until(lambda: len(bench.clocks) > 30, what="the string to move")
    yield process
    assert process.end() == 0, process.text
    assert "Traceback" not in process.text


def test_a_paused_run_stands_still_steps_as_asked_and_goes_on(bench, running):
    ok, said = _do(bench, "pause")
    assert ok, said
    assert said.startswith("paused at t = ")
    bench.drain()
    frames, still = _frames(bench)[-1], len(bench.clocks)
    status = bench.until_status("simulator", lambda status: "paused at" in status.text)
    assert status.level == 0
    bench.drain()
    assert len(bench.clocks) == still
    assert _do(bench, "step")[0]
    assert bench.set_parameter("simulator", "step_frames", 7).successful
    assert _do(bench, "step") == (True, f"7 frames on, at t = {(frames + 8) / 100:g} s")
    bench.drain()
    assert _frames(bench) == list(range(1, frames + 9))  # none left out, none twice
    assert _do(bench, "resume")[0]
    bench.until(lambda: len(bench.clocks) > still + 30, what="time to go on")
    ok, said = _do(bench, "step")
    assert not ok
    assert "call /simulator/pause first" in said


def _begin_step(bench, frames):
    """Ask for a step; its answer comes later."""
    assert bench.set_parameter("simulator", "step_frames", frames).successful
    client = bench.node.create_client(Trigger, "/simulator/step")
    bench.until(client.service_is_ready)
    return client.call_async(Trigger.Request())


def test_a_step_of_a_hundred_thousand_frames_leaves_the_simulator_answering(bench, running):
    """Each frame is shorter than the slice of work in which compiled code asks for a stop; all take 20 s and more."""
    assert _do(bench, "pause")[0]
    step, before = _begin_step(bench, 100_000), len(bench.clocks)
    bench.until(lambda: len(bench.clocks) > before + 100, what="frames of the step")
    bench.until_status("simulator", bool, 10.0)
    ok, said = _do(bench, "step")
    assert not ok
    assert "found a run taking" in said
    assert not step.done()
    assert _do(bench, "pause")[0]
    bench.until(step.done, what="the answer to the step")
    assert not step.result().success
    assert "as the run was paused meanwhile" in step.result().message
    bench.drain()
    still = len(bench.clocks)
    bench.spin(0.3)
    assert len(bench.clocks) == still
    step = _begin_step(bench, 100_000)
    bench.until(lambda: len(bench.clocks) > still + 100, what="frames of another step")
    running.send(signal.SIGTERM)
    assert running.wait(10.0) == 0, running.text


def test_a_checkpoint_replaces_its_own_kind_only_in_the_folder_that_was_named_at_the_start(bench, running):
    elsewhere = bench.folder / "elsewhere"
    elsewhere.mkdir()
    for folder in (bench.folder, elsewhere):
        with zipfile.ZipFile(folder / "important.xlsx", "w") as archive:
            archive.writestr("xl/workbook.xml", "<workbook/>")
    content = (bench.folder / "important.xlsx").read_bytes()
    (bench.folder / "link.npz").symlink_to(elsewhere / "important.xlsx")
    refused = ("elsewhere/important.xlsx", "link.npz", "new/run.npz", "../run.npz", "/nonexistent/run.npz", "elsewhere",
               "\x1b[31mred.npz")  # fmt: skip
    for name in refused:
        for parameter in ("saved_checkpoint", "checkpoint"):
            result = bench.set_parameter("simulator", parameter, str(bench.folder / name))
            assert not result.successful, name
            assert "expected" in result.reason
    assert bench.set_parameter("simulator", "saved_checkpoint", str(bench.folder / "important.xlsx")).successful
    ok, said = _do(bench, "save_checkpoint")
    assert not ok
    assert "another file there, which is not replaced" in said
    for folder in (bench.folder, elsewhere):
        assert (folder / "important.xlsx").read_bytes() == content
    assert not (bench.folder / "new").exists()
    assert bench.set_parameter("simulator", "saved_checkpoint", str(bench.folder / "run2.npz")).successful
    for _ in range(2):  # its own file is replaced
        assert _do(bench, "save_checkpoint")[0]
    assert "\x1b" not in running.text


def test_a_simulator_refuses_a_folder_as_the_file_of_its_checkpoint(bench):
    process = bench.start("simulator", checkpoint="/")
    assert process.wait() == 2
    assert "/: expected the path of a file for a checkpoint, found a folder" in process.text


def test_a_reset_run_begins_again_with_a_scene_of_its_own(bench, running):
    bench.until(lambda: len(bench.scenes) == 1)
    assert _do(bench, "reset") == (True, "began again at t = 0 s")
    bench.until(lambda: len(bench.scenes) == 2, what="the scene of the new run")
    status = bench.until_status("simulator", lambda status: status.values["simulated_time"] == "0.000000")
    assert status.text == "waiting for the first command"
    assert read_clock(bytes(bench.clocks[-1])) == 0
    bench.publisher(RIG_COMMAND).publish(CommandEncoder().command(FRAME, Command(40.0, 12.0)))
    before = len(bench.clocks)
    bench.until(lambda: len(bench.clocks) > before + 10)
    assert read_clock(bytes(bench.clocks[before])) == FRAME


def test_a_loaded_checkpoint_gives_the_same_frames_again(bench, running):
    poses = bench.collect(STRING_POSES)
    states = bench.collect(RIG_STATE)
    assert _do(bench, "pause")[0]
    ok, said = _do(bench, "save_checkpoint")
    assert ok, said
    assert str(bench.saved) in said
    assert bench.set_parameter("simulator", "step_frames", 50).successful
    runs = []
    for _ in range(2):
        bench.until_ready("simulator")
        poses.clear(), states.clear()
        assert _do(bench, "step")[0]
        bench.drain()
        runs.append(([bytes(raw) for raw in poses], [bytes(raw) for raw in states]))
        assert _do(bench, "load_checkpoint")[0]
        bench.drain()
    assert len(runs[0][0]) == 50
    assert runs[0] == runs[1]


def test_a_saved_checkpoint_is_not_overwritten_by_the_periodic_one(bench, running):
    ok, said = _do(bench, "save_checkpoint")
    assert ok, said
    saved = bench.saved.read_bytes()
    assert bench.set_parameter("simulator", "checkpoint_period", 0.2).successful
    bench.until_status("simulator", lambda status: float(status.values["checkpoint_time"] or 0.0) > 1.0)
    assert bench.saved.read_bytes() == saved
    assert bench.file.read_bytes() != saved
    ok, said = _do(bench, "load_checkpoint")
    assert ok, said
    assert str(bench.saved) in said


def test_without_a_checkpoint_the_services_say_what_is_missing(bench, running):
    ok, said = _do(bench, "load_checkpoint")
    assert not ok
    assert "expected a checkpoint, found nothing there" in said
    bench.saved.write_bytes(b"rubbish")
    ok, said = _do(bench, "load_checkpoint")
    assert not ok
    assert "expected a whole checkpoint" in said
    assert bench.set_parameter("simulator", "checkpoint", "").successful
    ok, said = _do(bench, "save_checkpoint")
    assert not ok
    assert "ros2 param set /simulator saved_checkpoint" in said
    assert bench.set_parameter("simulator", "checkpoint", str(bench.file)).successful
    assert bench.set_parameter("simulator", "saved_checkpoint", str(bench.file)).successful
    ok, said = _do(bench, "save_checkpoint")
    assert not ok
    assert "expected another file than the periodic checkpoint" in said
    before = len(bench.clocks)
    bench.until(lambda: len(bench.clocks) > before + 10, what="time to go on all the same")


@pytest.mark.long
@pytest.mark.fault("simulator killed (-9) and restarted", "it goes on from its checkpoint, bit for bit")
def test_a_simulator_that_is_killed_goes_on_from_its_checkpoint(bench):
    """As the same run without the kill, bit for bit: the driver answers by the clock."""
    file = str(bench.folder / "run.npz")
    states = bench.collect(RIG_STATE)
    given = {"pace": "lockstep", "checkpoint": file, "checkpoint_period": 0.2}
    simulator = bench.start("simulator", duration=60.0, **given)
    driver = bench.start("rig_driver", wait_for="simulator test")
    bench.until_status("simulator", lambda status: float(status.values["checkpoint_time"] or 0.0) > 0.5)
    simulator.kill()
    bench.drain()
    before = {raw[4:12]: raw for raw in map(bytes, states)}
    states.clear()
    end = max(int.from_bytes(stamp[:4], "little") for stamp in before) + 2
    simulator = bench.start("simulator", duration=float(end), **given)
    bench.until(lambda: simulator.code is not None, what="the run to end")
    assert simulator.code == 0, bench.logs()
    assert "going on from" in simulator.text
    bench.drain()
    after = {raw[4:12]: raw for raw in map(bytes, states)}
    both = set(before) & set(after)
    assert both, "the checkpoint is older than the kill"
    assert all(before[stamp] == after[stamp] for stamp in both)
    assert {int.from_bytes(s[:4], "little") * 100 + int.from_bytes(s[4:], "little") // FRAME for s in after} >= set(
        range(len(before) + 1, end * 100 + 1)
    )
    assert driver.end() == 0
    # Where the file stands at the end of the run, nothing is left to do, and that is said.
    again = bench.start("simulator", duration=float(end), **given)
    assert again.wait() == 2
    assert "where the run was over" in again.text
