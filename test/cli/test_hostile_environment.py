# SPDX-License-Identifier: Apache-2.0
"""Commands with odd paths, closed streams, no working folder, little memory: one sentence and an exit code, or work."""

import os
import subprocess
import sys
from io import StringIO

import pytest

from drill_twin.cli import run_command, show
from drill_twin.core.errors import BagError, DrillTwinError, SceneError, StoppedError, TableError, printable
from drill_twin.core.files.plain_json import json_text
from drill_twin.core.table import Table
from drill_twin.io.bag.reader import Bag
from drill_twin.io.bag.skipped import SkippedMessages
from drill_twin.scene import load_scene, parse_scene
from drill_twin.scene.set_points.tables import read_table

COMMAND = f"{sys.executable} -m drill_twin.cli"
ODD = "a\x1b]0;title\x07b\x9b2Jc\u202egnp.exe\u2066\nfake: error\r\x00\ud800"


def shell(text, folder):
    environment = {**os.environ, "COLUMNS": "100"}
    command = ["bash", "-c", text]
    done = subprocess.run(command, cwd=folder, capture_output=True, timeout=300, check=False, env=environment)
    said = (done.stdout + done.stderr).decode("utf-8", "replace")
    assert "Traceback" not in said, said
    assert "Exception ignored" not in said, said
    return done.returncode, said


@pytest.mark.parametrize("path", ["x" * 5000, "x/" * 3000, "a\0b", "~nosuchuser/scene.yaml", "loop/x"])
def test_paths_that_cannot_be(path, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "loop").symlink_to("loop")
    for read, error in ((load_scene, SceneError), (Bag, BagError), (read_table, TableError)):
        with pytest.raises(error) as caught:
            read(path)
        assert len(str(caught.value)) < 11_000
    table = "rig: {table: {file: " + (f'"{path}"' if "\0" not in path else '"a\\0b"') + "}}\nbase: pa6_bench\n"
    with pytest.raises((SceneError, TableError)):
        read_table(parse_scene(table).rig.table.file)


def test_a_command_with_a_path_of_5000_characters(tmp_path):
    code, said = shell(f"{COMMAND} scene check {'x' * 5000}", tmp_path)
    assert code == 2
    assert "File name too long" in said
    assert len(said) < 1000


LONG = pytest.mark.long


@pytest.mark.parametrize(
    "closed", [">&- 2>&-", *(pytest.param(text, marks=LONG) for text in ("<&- >&-", ">&-", "2>&-"))]
)
def test_closed_streams(closed, tmp_path):
    code, said = shell(f"{COMMAND} ros topics {closed}", tmp_path)
    assert (code, "error" in said) == (0, False)


@LONG
def test_a_reader_that_closes_its_end(tmp_path):
    code, _ = shell(f"set -o pipefail; {COMMAND} scene list | head -c 1 > /dev/null", tmp_path)
    assert code in {0, 1}


@LONG
def test_a_full_device(tmp_path):
    code, said = shell(f"{COMMAND} ros topics > /dev/full", tmp_path)
    assert code == 1
    assert "No space left on device" in said


@LONG
@pytest.mark.parametrize("command", ["scene check pa6_bench", "run pa6_bench --duration 0.1", "analyze bag_0"])
def test_a_removed_working_folder(command, tmp_path):
    code, said = shell(f'mkdir gone && cd gone && rmdir "$PWD" && {COMMAND} {command}', tmp_path)
    assert code != 0 or command.startswith("scene")
    assert said.count("error:") <= 1


def test_little_memory_is_refused_before_the_libraries_fail(tmp_path):
    code, said = shell(f"ulimit -v 600000; {COMMAND} run pa6_bench", tmp_path)
    assert code == 1
    assert "MB of address space, found a limit of 614 MB; raise it with `ulimit -v`" in said
    code, said = shell(f"ulimit -v 600000; {sys.executable} -m drill_twin.ros simulator", tmp_path)
    assert code == 1
    assert "MB of address space" in said


def test_text_of_unknown_origin_is_written_out():
    assert printable("40 N, über, 穴, Ω") == "40 N, über, 穴, Ω"
    assert printable("a\nb") == "a\nb"
    assert printable("a\nb", keep="") == r"a\nb"
    assert printable(ODD, keep="").isprintable()
    assert printable("\x1b[2J\u202e\x9b") == r"\x1b[2J\u202e\x9b"
    assert str(BagError(ODD)).replace("\n", "").isprintable()
    assert str(StoppedError(ODD, 0.0, "", 0, "")).replace("\n", "").isprintable()
    assert issubclass(SceneError, DrillTwinError)
    skipped = SkippedMessages()
    skipped.add("/t", 0.0, ODD)
    assert all(text.isprintable() for text in skipped.sentences())
    assert json_text({"name": ODD.replace("\ud800", "")}).replace("\n", "").isprintable()


def test_names_of_a_bag_do_not_reach_the_terminal_as_they_are():
    stream = StringIO()
    console = show.out()
    console.file = stream
    odd = ODD.replace("\ud800", "")
    console.print(Table(("a", "b"), [(odd, odd)]))
    console.print(Table((), [(odd, odd)]))
    console.print(odd, markup=False)
    text = stream.getvalue()
    assert r"\x1b" in text
    assert text.replace("\n", "").isprintable()


@pytest.mark.parametrize(
    "key", ["9" * 5000, f"string.sections[{'9' * 5000}]", "string.sections[\u00b2].length", "x." * 5000]
)
def test_keys_of_overrides_that_cannot_be(key, capsys):
    assert run_command(["scene", "check", "pa6_bench", "--set", f"{key}=1"]) == 2
    said = capsys.readouterr().err
    assert "error:" in said
    assert len(said) < 3100


@pytest.mark.parametrize("text", ["9" * 5000, "-1", "\u00b2", "1e5"])
def test_domains_that_cannot_be(text, monkeypatch):
    from drill_twin.ros import deployment as discovery

    monkeypatch.setenv("ROS_DOMAIN_ID", text)
    with pytest.raises(DrillTwinError, match="ROS_DOMAIN_ID"):
        discovery.prepare()
