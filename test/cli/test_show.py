"""What commands print: remarks as they are, results whatever becomes of their files, progress without a terminal."""

import json
import re

import pytest

from drill_twin.cli import show
from drill_twin.cli.emit import emit
from drill_twin.cli.show import remark
from drill_twin.core.errors import BagError
from drill_twin.core.table import Table


def test_a_remark_is_a_line_on_stderr_as_it_is(capsys):
    remark("[bold] :bug: " + "words " * 60 + "\x1b[31m")
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err == "[bold] :bug: " + "words " * 60 + "\\x1b[31m\n"


def test_files_are_written_and_named(tmp_path, capsys):
    files = {"a.json": {"x": float("nan")}, "b.txt": "text\n", "c.json": lambda: [1]}
    emit(None, [Table(("a",), [("1",)]), "a line"], json=False, folder=tmp_path / "out", files=files, also=["runs"])
    said = capsys.readouterr()
    assert [line.strip() for line in said.out.splitlines() if line.strip()] == ["a", "─", "1", "a line"]
    assert said.err == f"{tmp_path / 'out'}: a.json, b.txt, c.json, runs\n"
    assert json.loads((tmp_path / "out" / "a.json").read_text()) == {"x": None}
    assert (tmp_path / "out" / "b.txt").read_text() == "text\n"
    assert json.loads((tmp_path / "out" / "c.json").read_text()) == [1]


def test_json_is_all_of_stdout_and_the_tables_are_not_computed(capsys):
    def shown():
        raise AssertionError("computed")
        yield ""

    emit({"x": 1}, shown(), json=True)
    assert json.loads(capsys.readouterr().out) == {"x": 1}


def test_the_result_is_printed_even_if_a_file_cannot_be_written(tmp_path, capsys):
    (tmp_path / "out").write_text("a file")
    with pytest.raises(BagError, match="expected a place to write the result"):
        emit(None, ["the result"], json=False, folder=tmp_path / "out", files={"a.json": 1})
    said = capsys.readouterr()
    assert said.out == "the result\n"
    assert said.err == ""


@pytest.mark.parametrize(("most", "words"), [(False, ""), (True, "at most ")])
def test_without_a_terminal_progress_is_a_line_now_and_then(capsys, monkeypatch, most, words):
    now = [100.0]
    monkeypatch.setattr(show.time, "monotonic", lambda: now[0])
    with show.shown_progress("running", 4, unit="runs", most=most) as bar:
        for text in ("first", "second", "third"):
            bar.step(text)
            now[0] += 6.0
        bar.show("fourth", 4)
    assert re.fullmatch(rf"third, 3 of {words}4 runs, {words}\d:\d\d:\d\d left\n", capsys.readouterr().err)


def test_in_a_terminal_a_line_is_broken_between_words_and_a_path_stays_whole(capsys):
    path = "/a/" + "long/" * 10 + "path"
    show.PrintableConsole(width=40, force_terminal=True, highlight=False).say(f"{'words ' * 20}{path}")
    said = capsys.readouterr().out.splitlines()
    assert max(map(len, said[:-1])) <= 40
    assert said[-1] == path
