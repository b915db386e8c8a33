# SPDX-License-Identifier: Apache-2.0
"""Scenes and results of a folder, new names in it, and the forms of the commands."""

import os

import pytest

from drill_twin.cli.app import commands
from drill_twin.core.errors import BagError
from drill_twin_dashboard.front import folder as folder_module
from drill_twin_dashboard.front import forms as forms_module
from drill_twin_dashboard.front.folder import Folder
from drill_twin_dashboard.front.forms import COMMANDS, FIRST, LEFT_OUT, forms


def write(path, text=""):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, "utf-8")


def test_scenes_and_results_are_found_and_nothing_else(tmp_path):
    write(tmp_path / "a.yaml", "# well\nname: a\nstring:\n  sections: []\n")
    write(tmp_path / "wells" / "b.yml", "base: pa6_bench\n")
    write(tmp_path / "wrong.yaml", "hole: {radius: [}\n")  # the command says what is wrong with it
    write(tmp_path / "-rf.yaml", "string: 1\n")
    write(tmp_path / "record.yaml", "channels:\n  string: x\n")
    write(tmp_path / ".hidden" / "c.yaml", "string:\n")
    write(tmp_path / "1" / "2" / "3" / "4" / "5" / "deep.yaml", "string:\n")
    os.mkfifo(tmp_path / "pipe.yaml")
    (tmp_path / "circle").symlink_to(tmp_path, target_is_directory=True)
    write(tmp_path / "out" / "run" / "bag_0" / "metadata.yaml")
    for name in ("summary.json", "report.html", "well.png"):
        write(tmp_path / "out" / "run" / name)
    write(tmp_path / "bag" / "metadata.yaml")
    for name in ("statics.json", "statics.png", "statics.csv"):
        write(tmp_path / "out" / "statics" / name)
    write(tmp_path / "photos" / "rig.png")
    write(tmp_path / "live" / "metadata.yaml")
    for age, name in enumerate(("out/run", "live", "out/statics", "bag")):
        os.utime(tmp_path / name, (1e9 - age, 1e9 - age))
    listed = Folder(tmp_path).listed()
    assert listed["scenes"] == ["./-rf.yaml", "a.yaml", "wells/b.yml", "wrong.yaml"]
    assert [(one["name"], one["bag"], one["files"]) for one in listed["results"]] == [
        ("out/run", True, ["report.html", "well.png", "summary.json"]),
        ("./live", True, ["metadata.yaml"]),  # `drill-twin watch live` is the running twin
        ("out/statics", False, ["statics.png", "statics.json", "statics.csv"]),
        ("bag", True, ["metadata.yaml"]),
    ]
    assert not listed["cut"]


def test_of_a_huge_folder_a_part_is_looked_at_and_this_is_told(tmp_path, monkeypatch):
    monkeypatch.setattr(folder_module, "MOST", 3)
    for name in "abc":
        write(tmp_path / name / "x.yaml", "string:\n")
    assert Folder(tmp_path).listed()["cut"]


def test_new_names_and_content(tmp_path):
    folder = Folder(tmp_path)
    assert folder.fresh("out/run") == "out/run"
    assert folder.fresh("out/run", taken={"out/run"}) == "out/run_2"
    write(tmp_path / "a.csv", "old")
    assert folder.fresh("a", ".csv", content=b"old") == "a.csv"
    assert folder.fresh("a", ".csv", content=b"new") == "a_2.csv"
    assert folder.fresh("a", ".csv", content=b"newer") == "a_3.csv"
    assert folder.fresh("a", ".csv", content=b"new") == "a_2.csv"
    assert [(tmp_path / name).read_bytes() for name in ("a.csv", "a_2.csv", "a_3.csv")] == [b"old", b"new", b"newer"]
    with pytest.raises(BagError, match=r"none/a\.csv: expected a place to write a file, found "):
        folder.fresh("none/a", ".csv", content=b"x")


def test_a_form_has_every_option_that_its_command_declares():
    declared = {name.partition(" ")[2]: command for name, command in commands()}
    found = forms()
    assert list(found) == list(COMMANDS)
    for name, form in found.items():
        options = [item for item in declared[name].params if item.param_type_name == "option"]
        left_out = {flag for item in options for flag in item.opts} & {*LEFT_OUT.split(), "--browser"}
        assert len(form["fields"]) == len(options) - len(left_out), name
        assert not set(form["fields"]) & set(LEFT_OUT.split())
    assert {field for form in found.values() for field in form["fields"]} >= set(FIRST.split())
    new, run, map_ = (found[name]["fields"] for name in ("scene new", "run", "map"))
    assert [new[name]["kind"] for name in ("--survey", "--hole", "--casing", "--units")] == [
        "table", "text", "list", "choice",
    ]  # fmt: skip
    assert (new["--mud"]["default"], run["--units"]["default"], run["--duration"]["default"]) == (
        "1.2 sg",
        "the scene's",
        "",
    )
    assert run["--report"]["kind"] == run["--no-check"]["kind"] == "flag"  # the flag that changes the default
    assert (map_["--wob"]["first"], map_["--steps"]["first"]) == (True, False)
    assert [form["target"] for form in found.values()] == ["FILE", *5 * ["SCENE"], "CASE", *3 * ["BAG"]]


@pytest.mark.process
def test_a_command_of_a_package_that_is_not_installed_says_what_to_install(front, monkeypatch):
    monkeypatch.setattr(forms_module, "commands", list)
    assert forms()["map"] == {"help": "", "target": "SCENE", "target_help": "", "fields": {}}
    front.server._forms["map"] = forms()["map"]  # noqa: SLF001
    (front.folder / "sitecustomize.py").write_text(
        "import drill_twin.core.companions as c\nc.entries = lambda group: ()\n", "utf-8"
    )
    monkeypatch.setenv("PYTHONPATH", f"{front.folder}{os.pathsep}{os.environ.get('PYTHONPATH', '')}")
    assert front.ask(do="map", on=["pa6_bench"]) == ""
    ended = front.ended()
    assert ended["code"] == 2
    assert "needs the package drill_twin_studies" in ended["text"]
    assert "pip install drill_twin_studies" in ended["text"]
