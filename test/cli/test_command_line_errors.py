# SPDX-License-Identifier: Apache-2.0
"""Mistakes: one line on stderr that says what to do, exit code 2, nothing on stdout, nothing lost."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from drill_twin.cli.emit import new_folder
from drill_twin.io.bag.reader import Bag
from drill_twin.io.bag.writer import BagWriter
from drill_twin.io.messages.diagnostics import encode_diagnostics
from drill_twin.io.messages.topics import DIAGNOSTICS, MARKS_STATE

SCENE = "name: bad\nstring:\n  sections: {}\n"


@pytest.fixture
def field(inside, bench_run):
    """Files of every wrong kind."""
    (inside / "malformed.yaml").write_text("name: [unfinished\nstring: }")
    (inside / "wrong.yaml").write_text(SCENE)
    (inside / "empty.mcap").touch()
    (inside / "text.mcap").write_text("hello\n")
    (inside / "nothing").mkdir()
    (inside / "full").mkdir()
    (inside / "full" / "precious.txt").write_text("mine")
    (inside / "taken").mkdir()
    for name in ("summary.json", "scene.schema.json"):
        (inside / "taken" / name).write_text("mine")
    shutil.copytree(bench_run.bag, inside / "good" / "bag_0")
    with BagWriter(inside / "foreign_0", topics=[DIAGNOSTICS]) as bag:
        bag.write(DIAGNOSTICS, 1, encode_diagnostics(1, []))
    with BagWriter(inside / "silent_0"):
        pass
    return inside


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (
            ["report", "good", "--units", "klbf"],
            "--units: expected one of 'field', 'si', 'lab', found klbf; see `drill-twin report --help`",
        ),
        (["run", "nope"], "nope: no such scene file; expected a path or one of the installed scenes: bha_full_size"),
        (["run", "pa6_bnech"], 'did you mean "pa6_bench"?'),
        (["run", "malformed.yaml"], "malformed.yaml:"),
        (["run", "wrong.yaml"], "wrong.yaml:"),
        (["study", "whirl-compare", "pa6_bench", "--wob", "40..10:4 N", "--rpm", "60..120:2"], "with LO below HI"),
        (["scene", "check", "malformed.yaml"], "malformed.yaml:"),
        (["run", "nothing"], "expected a scene file, found a folder"),
        (["run", "pa6_bench", "--wob", "40 kg"], 'expected a force such as "40 N", found "40 kg" (mass)'),
        (["run", "pa6_bench", "--duration", "nan s"], "duration"),
        (["run", "pa6_bench", "--rpm", "1e9"], "rotation"),
        (["run", "pa6_bench", "--set", "hole.radius"], '--set: expected KEY=VALUE such as "hole.radius=80 mm", found'),
        (["run", "pa6_bench", "--set", "hole.raduis=80 mm"], 'did you mean "radius"?'),
        (["run", "pa6_bench", "--set", "hole.radius=[oops"], "hole.radius"),
        (["run", "pa6_bench", "--out", "full"], "found one with precious.txt in it; choose another with --out"),
        (["run", "pa6_bench", "--out", "full", "--replace"], "expected the result of an earlier run to replace"),
        (["run", "pa6_bench", "--out", "text.mcap"], "found one with a file in it"),
        (["run", "pa6_bench", "--out", "text.mcap/x"], "expected a place to write the result"),
        (["run", "ufrj_rig"], "rig.table.file"),
        (["cost", "pa6_bench", "--out", "text.mcap"], "text.mcap/runs: expected a place to write the result"),
        (["run", "pa6_bench", "--accuracy", "1 %", "--set", "numerics.tolerance=1e-6"], "which chooses it"),
        (["run"], "expected SCENE, found nothing; see `drill-twin run --help`"),
        (["effects", "pa6_bench", "--wob", "40 N"], 'found --wob; did you mean --set "wob=..."?'),
        (["run", "pa6_bench", "--bogus"], "expected another option, found --bogus"),
        (["frobnicate"], 'expected a command, found "frobnicate"'),
        (["analyze", "missing"], "missing: expected a bag folder or file, found nothing there"),
        (["analyze", "nothing"], "found nothing in it"),
        (["analyze", "full"], "found precious.txt; not a bag"),
        (["analyze", "empty.mcap"], "found an empty file"),
        (["analyze", "text.mcap"], "that do not start as one"),
        (["analyze", "silent_0"], "expected messages, found none"),
        (["analyze", "foreign_0"], "the bag is of another package"),
        (["analyze", "foreign_0", "--json"], "the bag is of another package"),
        (["analyze", "good", "--scene", "nope"], "nope: no such scene file"),
        (["analyze", "good", "--scene", "bha_full_size"], "expected the marks of the scene on /marks/state"),
        (["analyze", "good", "--out", "taken"], "expected a new file, found an existing file"),
        (["analyze", "good", "--out", "text.mcap/x"], "expected a place to write the result"),
        (["report", "text.mcap"], "that do not start as one"),
        (["report", "good", "--out", "text.mcap"], "expected a place to write the report"),
        (
            ["export", "good", "--csv", "--from", "5", "--to", "1"],
            "expected a start before the end, found 5 s and 1 s",
        ),
        (["analyze", "good", "--from", "nan"], "--from: expected a time such as"),
        (["analyze", "no_bag", "--sub", "near_bit", "--marks", "mark_2"], "--marks: expected no marks beside --sub"),
        (["analyze", "no_bag", "--sub", ""], "--sub: expected a downhole sub, found no name; without --sub"),
        (["modes", "pa6_bench", "--out", "text.mcap"], "text.mcap: expected a place to write the result"),
        (["scene", "schema", "--out", "taken"], "expected a new file, found an existing file"),
        (["scene", "schema", "--out", "text.mcap/x"], "expected a place to write the file"),
    ],
)
def test_one_line_and_exit_code_2(call, field, arguments, words):
    before = sorted((path, path.is_file() and path.read_bytes()) for path in field.rglob("*"))
    said = call(*arguments)
    assert said.code == 2
    assert said.out == ""
    assert len(said.err.strip().splitlines()) == 1
    assert said.err.startswith("drill-twin: error: ")
    assert words in said.err
    assert sorted((path, path.is_file() and path.read_bytes()) for path in field.rglob("*")) == before


def test_an_absurd_path_is_cut(call, inside):
    said = call("analyze", "x" * 10_000)
    assert said.err.startswith(f"drill-twin: error: {'x' * 80}...{'x' * 79}: File name too long; check path")


def test_check_prints_every_problem_on_a_line_of_its_own(call, inside):
    (inside / "three.yaml").write_text("base: pa6_bench\nhole: {radius: 1 kg}\neffects: {wall: off, gravity: 3}\n")
    said = call("scene", "check", "three.yaml")
    lines = said.err.splitlines()
    assert (said.code, said.out, len(lines)) == (2, "", 3)
    assert all(line.startswith("drill-twin: error: ") for line in lines)
    for place in ("hole.radius", "effects.gravity", "effects.wall_friction"):
        assert f": {place}: expected " in said.err
    assert "(and 2 more problems: see `drill-twin scene check`)" in call("run", "three.yaml").err


def test_a_run_that_the_guard_stops_ends_with_another_code(call, inside):
    quick = [f"--set={key}" for key in ("rig.weight_on_bit.duration=0.1 s", "rig.rotation.duration=0.1 s")]
    coarse = ("--set=numerics.elements=8", "--out=stopped")
    said = call("run", "pa6_bench", "--wob", "3000 N", "--rpm", "6000", "--duration", "9", *quick, *coarse)
    assert said.code == 1
    assert "could not be followed" in said.err
    assert "list `wall`" not in said.err  # it is listed
    assert (inside / "stopped" / "bag_0_stop" / "checkpoint.npz").is_file()


def test_a_place_for_kernels_that_is_none_is_named(process, inside, monkeypatch):
    (inside / "file").touch()
    monkeypatch.setenv("DRILL_TWIN_CACHE", str(inside / "file" / "kernels"))
    said = process("run", "pa6_bench", "--duration", "0.1")
    assert said.code == 2
    assert "DRILL_TWIN_CACHE: expected a folder of your own that can be written to" in said.err


def test_no_traceback_from_a_process_of_its_own(process):
    said = process("analyze", "missing")
    assert (said.code, said.out) == (2, "")
    assert (
        said.err == "drill-twin: error: missing: expected a bag folder or file, found nothing there; check the path\n"
    )


def test_replaced_result_is_moved_aside_not_lost(call, inside):
    short = ("run", "pa6_bench", "--wob", "100", "--set", "rig.weight_on_bit.duration=1 s",
             "--set", "numerics.elements=8", "--duration", "0.05", "--out", "made")  # fmt: skip
    assert call(*short).code == 0
    (inside / "made" / "notes.txt").write_text("first")
    refused = call(*short)
    assert refused.code == 2
    assert "--replace to move that aside" in refused.err
    for number in ("", "2"):
        again = call(*short, "--replace")
        assert again.code == 0
        assert f"the older result is now made.old{number}" in again.err
        (inside / "made" / "notes.txt").write_text("again")
    assert (inside / "made.old" / "notes.txt").read_text() == "first"
    assert (inside / "made.old2" / "notes.txt").read_text() == "again"
    assert (inside / "made.old" / "bag_0" / "bag_0.mcap").exists()


def test_a_comparison_is_a_result_that_is_moved_aside(tmp_path):
    (tmp_path / "compare").mkdir()
    (tmp_path / "compare/compare.json").write_text("{}")
    moved = new_folder(tmp_path / "compare", replace=True)
    assert moved is not None
    assert (moved / "compare.json").read_text() == "{}"


def test_a_mistake_beside_replace_keeps_the_runs_of_a_map(call, inside):
    (inside / "map").mkdir()
    (inside / "map/runs.jsonl").write_text("hours")
    said = call("map", "pa6_bench", "--wob", "40..1 N", "--rpm", "60..120", "--out", "map", "--replace")
    assert said.code == 2
    assert len(said.err.splitlines()) == 1
    assert (inside / "map/runs.jsonl.old").read_text() == "hours"


def test_report_is_not_overwritten_unasked(call, field):
    page = field / "good" / "report.html"
    page.write_text("edited")
    refused = call("report", "good")
    assert refused.code == 2
    assert "expected a new file, found an existing file" in refused.err
    assert page.read_text() == "edited"
    assert call("report", "good", "--replace").code == 0
    assert page.stat().st_size > 1e6


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_folder_without_permission(call, inside):
    (inside / "locked").mkdir(mode=0o500)
    said = call("run", "pa6_bench", "--out", "locked/x")
    assert said.code == 2
    assert "Permission denied" in said.err


def test_disk_that_fills_up_keeps_what_was_written(inside):
    """A limit on the size of a file stands in for a full disk."""
    code = (
        "import resource, signal, sys; signal.signal(signal.SIGXFSZ, signal.SIG_IGN);"
        "from drill_twin.scene import load_scene; from drill_twin.runs import Session;"
        "session = Session(load_scene('pa6_bench', overrides={'wob': '100 N', 'rig.weight_on_bit.duration': '1 s',"
        "'numerics.elements': '8', 'duration': '3'}));"
        "import drill_twin.runs as module; module.Session = lambda *given: session;"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (300_000, 300_000));"
        "from drill_twin.cli import main; main(['run', 'pa6_bench', '--out', 'x'])"
    )
    environment = dict(os.environ, PYTHONPATH=str(Path(__file__).resolve().parents[2]))
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=300, check=False, env=environment
    )
    assert done.returncode == 2
    errors = [line for line in done.stderr.splitlines() if line.startswith("drill-twin: error: ")]
    assert len(errors) == 1
    assert "expected to go on writing the bag, found File too large" in errors[0]
    assert "Traceback" not in done.stderr
    assert Bag(inside / "x" / "bag_0").topics[MARKS_STATE].count > 20
