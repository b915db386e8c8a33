# SPDX-License-Identifier: Apache-2.0
"""A frame is computed in slices: the same bits however short they are, and an end of it in between takes it back."""

import os
import signal
import subprocess
import sys
import threading
from itertools import count

import numpy as np
import pytest
from variants import one_of

from drill_twin.core.errors import RunStopped, StoppedError
from drill_twin.dynamics.solver import slices
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.io.bag.reader import Bag
from drill_twin.io.messages.topics import RIG_STATE, STRING_POSES
from drill_twin.runs import Session
from drill_twin.runs.ensemble.parts import frames_of, planned
from drill_twin.runs.ensemble.run import on_threads
from drill_twin.scene import load_scene
from drill_twin.scene.set_points.command import Command

FORMS = {
    "spatial": {},
    "lateral": {"effects.stretch": "off", "effects.torsion": "off", "rig.weight_on_bit.at": "top"},
}
PUSHED = {
    "wob": "300 N",
    "rpm": "120",
    "rig.weight_on_bit.duration": "1 s",
    "rig.rotation.duration": "0.5 s",
    "duration": "10 s",
}
ENDLESS = {"numerics.step": "1 ns"}
"""Of a frame of 10 ms: ten million steps."""


def hard_scene(form, **changes):
    """300 N and a wall: contact, steps that are cut, and in the spatial form loose ones."""
    return load_scene("pa6_bench", overrides=PUSHED | FORMS[form] | changes)


def run(scene, seconds):
    """Columns of all frames of a run."""
    found = [[np.copy(array) for array in (frames.u, frames.v, frames.rig, frames.wall_force)]
             for frames in frames_of(Twin(scene), *planned(scene, seconds))]  # fmt: skip
    return [np.concatenate(column) for column in zip(*found, strict=True)]


def follow(twin, commands, period):
    """Advance frame by frame."""
    for command in commands:
        twin.advance(Command(*command), period)


@pytest.fixture
def shortest(monkeypatch):
    """Slices of one attempt of a step."""
    monkeypatch.setattr(slices, "WORK", 1)


@pytest.mark.parametrize("audit", one_of(2, ["none", "energy"]))
@pytest.mark.parametrize("form", FORMS)
def test_the_shortest_slices_give_the_same_bits(form, audit, monkeypatch):
    scene = hard_scene(form, **{"numerics.audit": audit})
    expected = run(scene, 0.6)
    monkeypatch.setattr(slices, "WORK", 1)
    paused = count()
    with slices.checked(lambda: next(paused) and None):
        found = run(scene, 0.6)
    assert next(paused) > 200
    for one, other in zip(found, expected, strict=True):
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("way", ["advance", "advance_frames", "fill"])
@pytest.mark.parametrize("form", FORMS)
def test_a_frame_ended_in_the_middle_is_taken_back(form, way, shortest):
    """The interrupt of a user comes in the middle of a frame; the run that goes on is the one without it."""
    scene = hard_scene(form)
    commands, period = planned(scene, 0.4)
    whole, broken = Twin(scene), Twin(scene)
    follow(whole, commands, period)
    slice_number = count()

    def interrupt():
        if next(slice_number) == 57:
            raise KeyboardInterrupt

    def go_on():
        if way == "fill":
            raise broken.fill(broken.record(len(commands)), commands, period)[1]
        if way == "advance_frames":
            broken.advance_frames(commands, period, broken.record(len(commands), nodes=False))
        follow(broken, commands, period)

    with slices.checked(interrupt), pytest.raises(KeyboardInterrupt):
        go_on()
    done = round(broken.time / period)
    assert 0 < done < len(commands)
    assert broken.time == pytest.approx(done * period, abs=1e-12)
    follow(broken, commands[done:], period)
    for name, array in whole.checkpoint().items():
        np.testing.assert_array_equal(array, broken.checkpoint()[name], err_msg=name)


def test_a_signal_as_compiled_code_returns_loses_no_frame(monkeypatch):
    """A handler runs at the first instruction of Python behind the frames that were computed meanwhile."""
    scene = hard_scene("spatial")
    commands, period = planned(scene, 0.2)
    twin = Twin(scene)
    record = twin.record(len(commands))
    whole = twin.dynamics.run

    def signalled(*arguments):
        whole(*arguments)
        raise KeyboardInterrupt

    monkeypatch.setattr(twin.dynamics, "run", signalled)
    frames, error = twin.fill(record, commands, period)
    assert isinstance(error, KeyboardInterrupt)
    assert frames.time[-1] == twin.time == pytest.approx(0.2)


def test_a_frame_that_takes_too_long_says_where_and_why(shortest):
    """Frames of 50 ms in one step, against a wall of steel."""
    scene = hard_scene(
        "spatial",
        **{"numerics.processor_time": "1 ms", "numerics.frame_rate": "20 Hz", "numerics.step": "50 ms"},
    )
    commands, period = planned(scene, 20.0)
    twin = Twin(scene)
    with pytest.raises(StoppedError) as stopped:
        follow(twin, commands, period)
    text = str(stopped.value)
    assert stopped.value.kind == "slow"
    assert "more than 0.001 s of processor time (numerics.processor_time)" in text
    assert "failed and were cut; Newton's method failed last at node" in text
    assert "strongest: " in text
    assert "a longer numerics.processor_time" in text
    assert twin.time == pytest.approx(round(twin.time / period) * period, abs=1e-12)


def test_a_frame_of_too_many_steps_says_so():
    twin = Twin(hard_scene("spatial", **ENDLESS | {"numerics.processor_time": "1 ms"}))
    with pytest.raises(
        StoppedError, match=r"steps of 27 elements led .* s into it, none was cut, .*longer numerics.step"
    ):
        twin.advance(Command(0.0, 1.0), 0.01)


def test_a_run_asked_to_stop_within_a_frame_keeps_the_frames_before(tmp_path, shortest):
    scene = hard_scene("spatial", **{"rig.duration": "0.3 s"})
    session, asked = Session(scene), count()
    whole = session.run(tmp_path / "whole")
    outcome = session.run(tmp_path / "stopped", stop=lambda: next(asked) >= 100)
    assert whole.finished
    assert not outcome.finished
    assert 0.0 < outcome.simulated < 0.3
    for topic in (RIG_STATE, STRING_POSES):
        kept = [raw for _, _, raw in Bag(outcome.bag).messages((topic,))]
        assert kept == [raw for _, _, raw in Bag(whole.bag).messages((topic,))][: len(kept)]
        assert len(kept) == round(outcome.simulated / 0.01)


def test_a_command_in_an_endless_frame_ends_when_asked(tmp_path):
    """Ten million steps a frame: without slices the process would go on for minutes."""
    command = [sys.executable, "-m", "drill_twin.cli", "run", "pa6_bench", "--wob=300 N", "--set=numerics.step=1 ns"]
    child = subprocess.Popen(
        [*command, "--out", str(tmp_path / "out")], stderr=subprocess.PIPE, text=True, cwd=tmp_path,
        env=dict(os.environ, PYTHONUNBUFFERED="1", PYTHONPATH=os.pathsep.join(sys.path)),
    )  # fmt: skip
    try:
        bag = tmp_path / "out" / "bag_0"
        wait = threading.Event()
        while child.poll() is None and not bag.exists():
            wait.wait(0.05)
        wait.wait(1.0)  # within the first frame
        child.send_signal(signal.SIGINT)
        _, said = child.communicate(timeout=30.0)
    finally:
        child.kill()
        child.wait()
    assert child.returncode == 130, said
    assert "stopped at 0.00 s; the bag is whole up to there" in said
    assert Bag(bag).scene()


def test_threads_in_endless_frames_end_with_the_interrupt_of_the_main_thread():
    scene = hard_scene("spatial", **ENDLESS)
    began = threading.Event()

    def endless(_item, _goes_on):
        twin = Twin(scene)
        began.set()
        twin.advance(Command(0.0, 1.0), 0.01)

    def interrupt():
        began.wait()
        signal.pthread_kill(threading.main_thread().ident, signal.SIGINT)

    threading.Thread(target=interrupt).start()
    with pytest.raises(KeyboardInterrupt):
        list(on_threads(endless, {1: None, 2: None}, 2))


def test_a_run_asked_to_stop_before_its_first_state_is_found_says_so(tmp_path):
    session = Session(hard_scene("spatial", **{"rig.start": "equilibrium"}))
    with pytest.raises(RunStopped):
        session.run(tmp_path / "bag", stop=lambda: True)


def test_a_search_for_an_equilibrium_can_be_ended(shortest):
    def stop():
        raise RunStopped

    with slices.checked(stop), pytest.raises(RunStopped):
        Twin(hard_scene("spatial", **{"rig.start": "equilibrium"}))
