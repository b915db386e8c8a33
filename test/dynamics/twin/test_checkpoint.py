# SPDX-License-Identifier: Apache-2.0
"""A run that goes on from a file is, bit for bit, the run that never stopped; a bad file says what is wrong with it."""

import io
import json
import os
import zipfile

import numpy as np
import pytest

from drill_twin.core.errors import CheckpointError
from drill_twin.dynamics.twin.checkpoint import Checkpoint
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.scene import load_scene, presets
from drill_twin.scene.set_points import Command, Schedule

FRAME = 0.01


def _run(twin, schedule, frames):
    first = round(twin.time / FRAME)
    return [twin.advance(schedule.at((first + k) * FRAME), FRAME) for k in range(1, frames + 1)]


@pytest.fixture(scope="module")
def schedule(bench_scene):
    return Schedule.from_scene(bench_scene)


@pytest.fixture(scope="module")
def kept(bench_scene, schedule, tmp_path_factory):
    """A checkpoint of a run in mid-whirl, and the frames that followed it."""
    twin = Twin(bench_scene)
    _run(twin, schedule, 150)
    path = tmp_path_factory.mktemp("kept") / "run.npz"
    Checkpoint.of(twin, schedule.at(twin.time)).save(path)
    return path, _run(twin, schedule, 100)


def _alike(one, other):
    arrays = ("positions", "velocities", "tangents", "spin", "spin_rate", "wall_force")
    assert all(np.array_equal(getattr(one, name), getattr(other, name)) for name in arrays)
    assert one.rig == other.rig
    assert one.time == other.time


def test_a_resumed_run_is_the_run_that_went_through(kept, schedule):
    path, wanted = kept
    for one, other in zip(_run(Checkpoint.load(path).twin(), schedule, 100), wanted, strict=True):
        _alike(one, other)


@pytest.mark.long
@pytest.mark.parametrize("name", sorted(presets()))
def test_every_installed_scene_can_be_resumed(name, tmp_path):
    """Whatever its effects remember (a sliding contact, a motor's lag, a cutting bit) is in the file."""
    scene = load_scene(name)
    command = Command(scene.rig.weight_on_bit.value or 100.0, scene.rig.rotation.value or 6.0)
    twin = Twin(scene)
    for _ in range(30):
        twin.advance(command, FRAME)
    Checkpoint.of(twin, command).save(tmp_path / "run.npz")
    resumed = Checkpoint.load(tmp_path / "run.npz").twin()
    for _ in range(30):
        _alike(resumed.advance(command, FRAME), twin.advance(command, FRAME))


def test_a_running_twin_goes_back_to_a_checkpoint(kept, bench_scene, schedule):
    path, wanted = kept
    twin = Twin(bench_scene)
    _run(twin, schedule, 30)
    checkpoint = Checkpoint.load(path)
    assert checkpoint.command == schedule.at(checkpoint.time)
    checkpoint.restore(twin)
    _alike(_run(twin, schedule, 1)[0], wanted[0])


@pytest.mark.parametrize("command", [Command(1.0, 0.0), Command(0.0, 2.0), Command(0.0, 0.0, -0.005)])
def test_every_set_point_is_kept(kept, tmp_path, command):
    checkpoint = Checkpoint.load(kept[0])
    Checkpoint(checkpoint.scene, checkpoint.time, command, checkpoint.arrays).save(tmp_path / "other.npz")
    assert Checkpoint.load(tmp_path / "other.npz").command == command


def test_no_state_is_forgotten(kept, schedule):
    """Were an array left out that matters, the runs would part: each one changed does make them part."""
    path, wanted = kept
    checkpoint = Checkpoint.load(path)
    for name in ("state.u", "state.v", "state.clock", "command"):
        arrays = {**checkpoint.arrays, name: checkpoint.arrays[name] + 1e-3}
        twin = Checkpoint(checkpoint.scene, checkpoint.time, checkpoint.command, arrays).twin()
        assert not np.array_equal(_run(twin, schedule, 1)[0].velocities, wanted[0].velocities), name


def test_a_checkpoint_of_another_scene_is_refused_with_the_line_that_differs(kept, bench_scene):
    other = load_scene("pa6_bench", overrides={"wob": "60 N"})
    twin = Twin(other)
    with pytest.raises(CheckpointError, match=r"of another scene: line \d+ of the resolved scene is \"duration: 1.0 s"):
        Checkpoint.load(kept[0]).restore(twin)
    assert twin.time == 0.0


def _rewritten(path, target, change):
    """A copy of a checkpoint with its head changed."""
    with np.load(path) as archive:
        arrays = dict(archive)
    head = json.loads(arrays["head"].tobytes())
    change(head, arrays)
    arrays["head"] = np.frombuffer(json.dumps(head).encode(), np.uint8)
    np.savez(target, **arrays)
    return target


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda head, _: head.update(version="0.0.1"), "found a checkpoint of 0.0.1"),
        (lambda head, _: head.update(format=99), "found a checkpoint of"),
        (lambda head, _: head.pop("scene"), "KeyError"),
        (lambda head, _: head.update(time="soon"), "whole checkpoint"),
        (lambda head, _: head.update(time=float("nan")), "finite numbers"),
        (lambda head, _: head.update(set_points=[1.0, 2.0, float("nan")]), "finite numbers"),
        (lambda head, _: head.update(set_points=[1.0, 2.0, 0.0, 3.0]), "whole checkpoint"),
        (lambda head, _: head.pop("set_points"), "KeyError"),
        (lambda head, _: head.update(scene="hole: [1"), "the checkpoint's scene"),
    ],
)
def test_a_head_that_does_not_fit_is_refused(kept, tmp_path, change, words):
    with pytest.raises(CheckpointError, match=words):
        Checkpoint.load(_rewritten(kept[0], tmp_path / "other.npz", change)).twin()


@pytest.mark.parametrize(
    "change",
    [
        lambda _, arrays: arrays.pop("state.u"),
        lambda _, arrays: arrays.update({"state.u": arrays["state.u"][:-1]}),
        lambda _, arrays: arrays.update(extra=np.zeros(3)),
    ],
)
def test_arrays_that_do_not_fit_are_refused(kept, tmp_path, change):
    checkpoint = Checkpoint.load(_rewritten(kept[0], tmp_path / "other.npz", change))
    with pytest.raises(CheckpointError, match=r"found other arrays: (state.u|extra)"):
        checkpoint.twin()


def test_what_is_no_checkpoint_is_refused(kept, tmp_path):
    whole = kept[0].read_bytes()
    broken = tmp_path / "broken.npz"
    for content in (b"", b"rubbish", whole[: len(whole) // 2], whole[:-1], whole[:200] + b"\xff" * 50 + whole[250:]):
        broken.write_bytes(content)
        with pytest.raises(CheckpointError, match=r"broken\.npz: expected a whole checkpoint"):
            Checkpoint.load(broken)
    with pytest.raises(CheckpointError, match="found nothing there"):
        Checkpoint.load(tmp_path / "none.npz")
    with pytest.raises(CheckpointError):
        Checkpoint.load(tmp_path)


def test_nothing_is_unpickled_and_no_forged_size_is_believed(kept, tmp_path):
    header = io.BytesIO()
    np.lib.format.write_array_header_1_0(header, {"descr": "<f8", "fortran_order": False, "shape": (2**40,)})
    pickled = io.BytesIO()
    np.lib.format.write_array(pickled, np.array([{"a": 1}], dtype=object), allow_pickle=True)
    for content in (header.getvalue(), pickled.getvalue()):
        target = tmp_path / "forged.npz"
        target.write_bytes(kept[0].read_bytes())
        with zipfile.ZipFile(target, "a") as archive:
            archive.writestr("state.extra.npy", content)
        with pytest.raises(CheckpointError, match="expected a whole checkpoint"):
            Checkpoint.load(target)


def test_a_place_that_cannot_be_written_is_said_and_the_older_one_stays(kept, tmp_path):
    checkpoint = Checkpoint.load(kept[0])
    (tmp_path / "file").write_text("")
    with pytest.raises(CheckpointError, match="expected a place for the checkpoint"):
        checkpoint.save(tmp_path / "file" / "run.npz")
    checkpoint.save(tmp_path / "run.npz")
    again = Checkpoint(checkpoint.scene, 9.0, Command(1.0, 2.0), checkpoint.arrays)
    again.save(tmp_path / "run.npz")
    assert Checkpoint.load(tmp_path / "run.npz").time == 9.0
    assert not list(tmp_path.glob("*.tmp"))


@pytest.mark.parametrize("place", ["letter.txt", "folder", "pipe", ".", "", "a\0b", "x" * 5000])
def test_a_checkpoint_replaces_no_other_file(kept, place, tmp_path, monkeypatch):
    """Whoever can set a parameter of the simulator names the file."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "letter.txt").write_text("Dear all", "utf-8")
    (tmp_path / "folder").mkdir()
    os.mkfifo("pipe")
    checkpoint = Checkpoint.load(kept[0])
    with pytest.raises(CheckpointError, match="expected a place for the checkpoint, found"):
        checkpoint.save(place)
    assert (tmp_path / "letter.txt").read_text("utf-8") == "Dear all"
    checkpoint.save("new.npz")
    checkpoint.save("new.npz")
