# SPDX-License-Identifier: Apache-2.0
"""From a scene to bag, findings and page, the way a user types it."""

import inspect
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from variants import one_of

from drill_twin import __version__
from drill_twin.cli.app import commands
from drill_twin.io.bag.reader import Bag
from drill_twin.io.messages.topics import MARKS_STATE, OF_SUBS, TOPICS
from drill_twin.report.figures import FIGURES
from drill_twin.scene import parse_scene, presets, well_scenes

COMMANDS = dict(commands())
SOURCE = str(Path(__file__).resolve().parents[2])
QUICK = (
    "--wob", "100 N", "--set", "rig.weight_on_bit.duration=1 s", "--set", "rig.rotation.duration=0.5 s",
    "--set", "effects.bow.amplitude=2 mm", "--set", "numerics.elements=8",
)  # fmt: skip
"""The same effects and numbers as the shared run has."""


def test_run_analyze_and_report(process, call, inside):
    ran = process("run", "pa6_bench", *QUICK, "--rpm", "120", "--duration", "1.5", "--out", "made/first", "--json")
    assert ran.code == 0, ran.err
    summary = json.loads(ran.out)
    folder = inside / "made" / "first"
    assert sorted(path.name for path in folder.iterdir()) == ["bag_0", "summary.json"]
    assert json.loads((folder / "summary.json").read_text("utf-8")) == summary
    assert summary["duration_s"] == 1.5
    assert summary["onset_s"] > 0.0
    assert summary["live"]["differing"] == 0
    assert "whirl began at" in ran.err

    analysed = call("analyze", folder / "bag_0", "--json")
    assert analysed.code == 0
    assert json.loads(analysed.out) == summary

    reported = call("report", folder)
    assert reported.code == 0
    assert reported.out.splitlines()[-1] == str(folder / "report.html")
    assert (folder / "report.html").stat().st_size > 1e6
    assert {file.stem for file in folder.glob("*.png")} == set(FIGURES)


def test_options_change_the_scene(call, inside):
    assert call("run", "pa6_bench", *QUICK, "--rpm=-90", "--duration", "0.05", "--out", "x").code == 0
    scene = parse_scene(Bag(inside / "x" / "bag_0").scene())
    assert scene.rig.weight_on_bit.value == 100.0
    assert scene.rig.rotation.value == pytest.approx(-1.5 * 6.283185307179586)
    assert (scene.rig.duration, scene.rig.weight_on_bit.duration, scene.numerics.elements) == (0.05, 1.0, 8)


def test_tables_say_what_was_found(call, bench_run):
    short = call("analyze", bench_run.bag)
    assert short.out.startswith("Whirl from ")
    assert len(short.out.splitlines()) < 12
    assert "--all" in short.err
    said = call("analyze", bench_run.bag, "--all")
    assert said.code == 0
    assert said.out.startswith(short.out.partition("\n\n")[0])
    for words in ("onset of whirl", "whirl frequency", "mark_3", "real-time factor", "the same, byte for byte",
                  bench_run.summary.motion[-1].state.value):  # fmt: skip
        assert words in said.out, words


def test_findings_can_be_written_to_a_file(call, bench_run, inside):
    said = call("analyze", bench_run.bag, "--json", "--out", "deep")
    assert json.loads((inside / "deep" / "summary.json").read_text("utf-8")) == json.loads(said.out)


def test_truncated_bag_is_analysed_and_said(call, bench_run, inside):
    whole = next(bench_run.bag.glob("*.mcap")).read_bytes()
    (inside / "cut.mcap").write_bytes(whole[: len(whole) // 2])
    said = call("analyze", "cut.mcap", "--json")
    assert said.code == 0
    assert json.loads(said.out)["truncated"] is True
    table = call("analyze", "cut.mcap")
    assert "the bag is not whole" in table.err


def test_report_goes_beside_the_bag_unless_told_otherwise(call, bench_run, inside):
    said = call("report", bench_run.bag, "--out", "there", "--json")
    assert said.code == 0
    files = json.loads(said.out)
    assert files["report"] == "there/report.html"
    assert all((inside / path).exists() for path in files["figures"].values())
    (inside / "loose.mcap").write_bytes(next(bench_run.bag.glob("*.mcap")).read_bytes())
    (inside / "loose_report").mkdir()
    (inside / "loose_report" / "report.html").write_text("older", "utf-8")
    assert f"{inside / 'loose_report' / 'report.html'}: expected a new file" in call("report", "loose.mcap").err


def test_scenes_are_listed_and_checked(call):
    listed = json.loads(call("scene", "list", "--json").out)
    assert [scene["scene"] for scene in listed] == [*presets(), *well_scenes()]
    assert "pa6_bench" in call("scene", "list").out
    checked = call("scene", "check", "pa6_bench", "--set", "hole.radius=70 mm", "--json")
    assert json.loads(checked.out)["hole_radius_m"] == 0.07
    assert "without errors" in call("scene", "check", "pa6_bench").out
    assert parse_scene(call("scene", "check", "pa6_bench", "--yaml").out).name == "pa6_bench"
    cased = "effects.wall_friction.intervals=[{top: 9 m, bottom: 12 m, coefficient: 0.1}]"
    told = call("scene", "check", "pa6_bench", "--set", cased).out
    assert "0.1 from 9 to 12 m" in told
    assert "below the bit at 5 m" in told


def test_schema_is_that_of_the_package(call, inside):
    printed = call("scene", "schema").out
    assert json.loads(printed)["$schema"]
    assert call("scene", "schema", "--out", ".").code == 0
    assert (inside / "scene.schema.json").read_text("utf-8") == printed


def test_topics_are_those_of_the_contract(call):
    assert [topic["name"] for topic in json.loads(call("ros", "topics", "--json").out)] == [
        *TOPICS,
        *(row.name for row in OF_SUBS),
    ]
    assert all(name in call("ros", "topics").out for name in TOPICS)


def test_demo_hands_its_options_on(process):
    said = process("ros", "demo", "--help")
    assert said.code == 0
    assert "--pace" in said.out
    assert "--replace" in said.out


def test_version(call):
    assert call("--version").out == f"drill-twin {__version__}\n"


@pytest.mark.parametrize("command", ["run", "analyze", "scene list", "scene schema", "ros topics"])
def test_every_command_explains_itself(call, command):
    said = call(*command.split(), "--help")
    assert said.code == 0
    assert said.err == ""
    assert f"drill-twin {command}" in said.out
    assert "--help" in said.out
    assert ("--json" in said.out) is (command != "scene schema")


def printed(code, folder=None):
    """Output of a new interpreter that runs a code in a folder."""
    environment = dict(os.environ, PYTHONPATH=SOURCE)
    return subprocess.run(
        [sys.executable, "-c", code], cwd=folder, capture_output=True, text=True, check=True, env=environment
    ).stdout


def test_help_loads_nothing_heavy(call):
    """So that it comes at once; 0.3 s were measured."""
    heavy = ("numpy", "numba", "pydantic", "matplotlib", "scipy", "rosbags", "plotly", "drill_twin.scene")
    code = f"import drill_twin.cli.app, sys; print([name for name in {heavy!r} if name in sys.modules])"
    assert printed(code).strip() == "[]"
    assert "run" in call().out  # no command at all shows the help


def test_a_run_imports_no_scipy_and_seldom_seeks_garbage():
    """Unless it needs a quantile or a mode: scipy takes 0.1 s to import, and a search for garbage 0.1 s of a start."""
    code = "import gc, sys, drill_twin.cli as cli, drill_twin.runs, drill_twin.report.summary\n"
    code += "found = {'scipy.special', 'scipy.linalg'}\n"
    code += "cli.end_process = lambda code: print(found & {*sys.modules}, gc.get_threshold()[0], code)\n"
    code += "cli.main(['--version'])"
    assert printed(code).splitlines()[1] == "set() 100000 0"


def test_a_run_imports_no_statistics(tmp_path):
    """Half a second of each run went to `scipy.signal`, which imports `scipy.stats`, for one spectrum.

    Compiled code imports the module of each function of numba in it, of which one asks scipy for BLAS: 0.1 s.
    """
    code = "import sys, drill_twin.cli as cli\n"
    code += "found = {'scipy.stats', 'scipy.signal', 'scipy.interpolate', 'scipy.linalg'}\n"
    code += "cli.end_process = lambda code: print(found & {*sys.modules}, code)\n"
    code += "cli.main(['run', 'pa6_bench', '--duration', '1', '--out', 'out'])"
    assert printed(code, tmp_path).splitlines()[-1] == "set() 0"


def test_tables_of_modes_and_statics_import_no_matplotlib():
    """Only figures need it: it takes 0.4 s."""
    code = "import sys, drill_twin.api.rotordynamics, drill_twin.studies.answers; print('matplotlib' in sys.modules)"
    assert printed(code).strip() == "False"


@pytest.mark.parametrize("number", one_of(2, [signal.SIGINT, signal.SIGTERM]))
def test_interrupted_run_keeps_a_whole_bag_and_says_so(start, inside, number):
    child = start("run", "pa6_bench", *QUICK, "--duration", "500", "--out", "long")
    deadline = time.monotonic() + 240.0
    bag = inside / "long" / "bag_0" / "bag_0.mcap"
    while not (bag.exists() and bag.stat().st_size > 200_000):
        assert child.poll() is None, child.communicate()
        assert time.monotonic() < deadline
        time.sleep(0.05)
    child.send_signal(number)
    out, err = child.communicate(timeout=20)
    assert child.returncode == 128 + number
    assert "Traceback" not in err
    assert "the bag is whole up to there: long/bag_0" in err
    assert out == ""
    left = Bag(inside / "long" / "bag_0")
    assert not left.truncated
    assert left.topics[MARKS_STATE].count > 0


def test_reader_that_leaves_early_is_no_error(start):
    child = start("ros", "topics", "--json")
    child.stdout.close()
    assert child.wait(timeout=60) in {0, 1}
    assert child.stderr.read() == ""


@pytest.mark.parametrize("name", COMMANDS)
def test_help_says_which_commands_need_ros(call, name):
    words, command = name.split()[1:], COMMANDS[name].callback
    source = inspect.getsource(command) if words[-1] != "load" else inspect.getsource(inspect.getmodule(command))
    needs = "drill_twin.ros" in source and words[-1] != "doctor"  # it says so where there is none
    help_text = "" if words[-1] == "demo" else call(*words, "--help").out
    assert ("ROS 2" in help_text + (command.__doc__ or "")) == needs
    assert not needs or words[0] in {"ros", "replay", "watch"}


def test_an_old_or_wrong_name_is_refused_with_the_one_that_was_meant(call):
    for name, now in (("list", "scene list"), ("doctor", "ros doctor"), ("verify", "study verify")):
        said = call(name, "--json")
        assert (said.code, said.out) == (2, "")
        assert said.err == f'drill-twin: error: expected a command, found "{name}"; it is "drill-twin {now}"\n'
    assert 'did you mean "drill-twin scene list"?' in call("scene", "lst").err


def test_a_group_alone_lists_its_commands(call):
    for group, one in (("scene", "schema"), ("ros", "doctor"), ("study", "verify")):
        said = call(group)
        assert said.code == 0
        assert one in said.out
