# SPDX-License-Identifier: Apache-2.0
"""The command `drill-twin scene new`, and short runs of the shipped wells."""

import json
import os
import pty
import select
import signal
import sys
import time
from contextlib import suppress
from pathlib import Path

import pytest
from typer.testing import CliRunner

from drill_twin.cli.app import app
from drill_twin.runs import Session
from drill_twin.scene import config_dir, load_scene, well_scenes

WELLS = config_dir() / "wells"
OPTIONS = [
    "--survey", str(WELLS / "s_shaped_survey.csv"), "--tally", str(WELLS / "s_shaped_tally.csv"), "--hole", "12 1/4 in",
    "--casing", "12.415 in to 1500 m", "--wob", "100 kN",
]  # fmt: skip


def test_new_writes_a_scene_that_check_accepts(tmp_path: Path) -> None:
    file = tmp_path / "s_shaped.yaml"
    said = CliRunner().invoke(app, ["scene", "new", str(file), *OPTIONS])
    assert said.exit_code == 0, said.output
    assert "3000 m, 5 sections, 8 stations" in said.stderr
    assert load_scene(file) == load_scene("wells/s_shaped")
    checked = CliRunner().invoke(app, ["scene", "check", str(file), "--json"])
    assert json.loads(checked.stdout)["length_m"] == 3000.0


@pytest.mark.parametrize(("key", "code", "said"), [
    (b"\x04", 2, "drill-twin: error: expected --survey, found nothing: CSV file of the survey"),
    (b"\x03", 130, "drill-twin: stopped"),
    (b"survey.csv\n\x04", 2, "drill-twin: error: expected --tally, found nothing: CSV file of the pipe tally"),
])  # fmt: skip
def test_a_question_that_gets_no_answer_ends_the_command(tmp_path: Path, key: bytes, code: int, said: str) -> None:
    """Ctrl-D and Ctrl-C at a question, in a terminal."""
    pid, terminal = pty.fork()
    if pid == 0:
        words = [sys.executable, "-m", "drill_twin.cli", "scene", "new", str(tmp_path / "well.yaml")]
        os.execv(sys.executable, words)  # noqa: S606  the child of a terminal of its own
    shown = b""
    while b"azimuth: " not in shown:
        shown += os.read(terminal, 1000)
    for part in key.splitlines(keepends=True):
        os.write(terminal, part)
        while part.endswith(b"\n") and b"gauge: " not in shown:
            shown += os.read(terminal, 1000)
    end = time.monotonic() + 120.0
    with suppress(OSError):  # the end of a terminal
        while time.monotonic() < end:
            if select.select([terminal], [], [], 1.0)[0]:
                shown += os.read(terminal, 1000)
            else:  # Ctrl-D is lost where it comes while readline takes the terminal over, after the question was shown
                os.write(terminal, part)
    if time.monotonic() >= end:
        os.kill(pid, signal.SIGKILL)
    assert os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]) == code
    os.close(terminal)
    assert said in " ".join(shown.decode().split())
    assert "Traceback" not in shown.decode()


def test_new_replaces_no_file_and_asks_for_what_is_missing(tmp_path: Path) -> None:
    file = tmp_path / "mine.yaml"
    file.write_text("mine")
    assert "--replace" in str(CliRunner().invoke(app, ["scene", "new", str(file), *OPTIONS]).exception)
    missing = CliRunner().invoke(app, ["scene", "new", str(tmp_path / "other.yaml"), *OPTIONS[2:]])
    assert "expected --survey, found nothing" in str(missing.exception)
    assert not (tmp_path / "other.yaml").exists()
    survey = tmp_path / "survey.csv"
    survey.write_text("mine")
    taken = CliRunner().invoke(app, ["scene", "new", str(survey), "--survey", str(survey), *OPTIONS[2:], "--replace"])
    assert "found the table of --survey" in str(taken.exception)
    assert survey.read_text() == "mine"


def test_a_tally_from_the_top_down_without_a_bit_is_turned_and_told(tmp_path: Path) -> None:
    tally, file = tmp_path / "tally.csv", tmp_path / "mine.yaml"
    tally.write_text(
        "kind,length [m],od [in],id [in],weight [lb/ft]\ndp,rest,5,,19.5\ncollar,90,6.5,2.8125,\nsub,1,6.5,3,\n"
    )
    said = CliRunner().invoke(app, ["scene", "new", str(file), *OPTIONS, "--tally", str(tally)])
    assert "tally.csv: turned round" in said.stderr
    assert [section.name for section in load_scene(file).string.sections] == ["sub", "collar", "dp"]


@pytest.mark.parametrize(("options", "told"), [
    ([], "bit: no type named, its law is sliding 0.4; --bit names one\n"),
    (["--bit", "12 in Tricone"], "bit: roller_cone\n"),
])  # fmt: skip
def test_the_law_of_the_bit_is_told(tmp_path: Path, options: list[str], told: str) -> None:
    said = CliRunner().invoke(app, ["scene", "new", str(tmp_path / "mine.yaml"), *OPTIONS, *options])
    assert told in said.stderr


def test_columns_of_a_tally_that_are_not_used_are_named(tmp_path: Path) -> None:
    """And a second column of the same kind: the first one counts."""
    tally, file = tmp_path / "tally.csv", tmp_path / "mine.yaml"
    tally.write_text("kind,length [m],od [in],id [in],joints,weight [lb/ft],wt (ppf)\ncollar,rest,8,3,9,148,22\n")
    said = CliRunner().invoke(app, ["scene", "new", str(file), *OPTIONS, "--tally", str(tally)])
    assert said.exit_code == 0, said.output
    assert "tally.csv: not used: joints, wt\n" in said.stderr
    (section,) = load_scene(file).string.sections
    assert section.mass_per_length == pytest.approx(148 * 0.45359237 / 0.3048)


@pytest.mark.long
@pytest.mark.parametrize("name", well_scenes())
def test_a_shipped_well_runs(tmp_path: Path, name: str) -> None:
    scene = load_scene(name, overrides={"rig.duration": "2 s"})
    outcome = Session(scene).run(tmp_path / "bag_0")
    assert outcome.finished
