# SPDX-License-Identifier: Apache-2.0
"""Files of results that go on: what a kill, a bad sector or another file leaves, and what is not touched."""

import os
import signal
import subprocess
import sys
import textwrap
from typing import NamedTuple
from unittest.mock import ANY

import pytest
from companion_parts import part
from typing_extensions import TypedDict

from drill_twin.core.errors import ArgumentError, BagError
from drill_twin.core.files.json_files import JsonLines

REGIMES, RUNS, SEARCH = (part(f"drill_twin_studies.maps.{name}") for name in ("regimes", "runs", "search"))

SETUP = {"scene": "bench", "duration": 30.0}


class Line(TypedDict):
    """Result without a type of its own."""

    result: int


def opened(file, setup=SETUP):
    lines = JsonLines(file, Line, "study", setup)
    return lines, [line["result"] for line in lines.results]


def written(file, count):
    lines, _ = opened(file)
    for number in range(count):
        lines.add({"result": number})
    return file.read_bytes().splitlines(keepends=True)


def test_results_are_read_back(tmp_path):
    written(tmp_path / "new folder" / "a.jsonl", 3)
    lines, found = opened(tmp_path / "new folder" / "a.jsonl")
    assert found == [0, 1, 2]
    assert lines.bad == 0


@pytest.mark.parametrize("damage", [
    b"\0" * 20 + b"\n", b'{"result": \n', b"[" * 100_000 + b"\n", b"{}\n", b"null\n", b"\xff\xfe\n", b"3\r4\n",
], ids=["zeros", "cut", "brackets", "another", "null", "no text", "return"])  # fmt: skip
def test_a_damaged_line_costs_its_own_result_only(tmp_path, damage):
    file = tmp_path / "a.jsonl"
    head, *rows = written(file, 4)
    file.write_bytes(head + rows[0] + damage + b"".join(rows[2:]))
    lines, found = opened(file)
    assert found == [0, 2, 3]
    assert lines.bad == 1
    lines.add({"result": 1})
    assert opened(file)[1] == [0, 2, 3, 1]


@pytest.mark.parametrize("cut", range(0, 70, 7))
def test_a_file_cut_anywhere_goes_on(tmp_path, cut):
    file = tmp_path / "a.jsonl"
    whole = b"".join(written(file, 2))
    file.write_bytes(whole[: len(whole) - cut])
    lines, found = opened(file)
    for number in range(len(found), 2):
        lines.add({"result": number})
    assert file.read_bytes() == whole


@pytest.mark.parametrize("text", [
    b"no newline at the end", b"two\nlines", b"\0", b'{"study": null}\n', b'{"study": []}\n', b"[" * 100_000 + b"\n",
], ids=["text", "lines", "zero", "null", "list", "brackets"])  # fmt: skip
@pytest.mark.parametrize("linked", [False, True])
def test_another_file_is_refused_and_not_touched(tmp_path, text, linked):
    target = tmp_path / "letter.txt"
    target.write_bytes(text)
    file = target
    if linked:
        file = tmp_path / "a.jsonl"
        file.symlink_to(target)
    with pytest.raises(ArgumentError, match="another file"):
        opened(file)
    assert target.read_bytes() == text


def test_another_setup_is_named(tmp_path):
    file = tmp_path / "a.jsonl"
    before = written(file, 1)
    with pytest.raises(ArgumentError, match="another duration"):
        opened(file, SETUP | {"duration": 20.0})
    assert file.read_bytes() == b"".join(before)


def test_a_pipe_a_device_and_a_folder_are_refused_at_once(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path / "pipe", "/dev/zero", "/dev/null"):
        with pytest.raises(BagError, match="expected a regular file"):
            opened(tmp_path / path)
    with pytest.raises(BagError, match="Is a directory"):
        opened(tmp_path)


def test_a_kill_loses_no_result_that_was_added(tmp_path):
    """`kill -9` while results are added: all that were told are in the file."""
    program = textwrap.dedent(f"""
        import sys
        from pathlib import Path
        from drill_twin.core.files.json_files import JsonLines
        lines = JsonLines(Path({str(tmp_path / "a.jsonl")!r}), dict, "study", {SETUP!r})
        for number in range(10**9):
            lines.add({{"result": number}})
            print(number, flush=True)
    """)
    with subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True) as process:
        for line in process.stdout:
            if int(line) == 500:
                process.send_signal(signal.SIGKILL)
                break
        told = [int(line) for line in process.stdout.read().splitlines()] or [500]
    assert opened(tmp_path / "a.jsonl")[1][: told[-1] + 1] == list(range(told[-1] + 1))


class Run(NamedTuple):
    """Result with types."""

    place: tuple[int, int]
    radius: float
    end: str | None = None


@pytest.mark.parametrize("damage", [
    b'[[1,"2"],0.5]', b"[[1,2,3],0.5]", b"[[1,2],null]", b'[[1,2],"0.5"]', b"[[1,2]]", b"[[1,2],[0.5]]",
    b"[[1,2],0.5,7]", b"[[1.5,2],0.5]", b"[[true,2],0.5]", b"[null,0.5]", b"7",
])  # fmt: skip
def test_a_line_of_the_right_shape_and_a_wrong_type_is_left_out(tmp_path, damage):
    file = tmp_path / "a.jsonl"
    lines = JsonLines(file, Run, "study", SETUP)
    for radius in (1, float("nan"), 0.25):
        lines.add(Run((1, 2), radius))
    head, *rows = file.read_bytes().splitlines(keepends=True)
    file.write_bytes(head + rows[0] + damage + b"\n" + rows[1] + rows[2])
    again = JsonLines(file, Run, "study", SETUP)
    assert again.bad == 1
    found = [(run.place, str(run.radius)) for run in again.results]
    assert found == [((1, 2), "1.0"), ((1, 2), "nan"), ((1, 2), "0.25")]


def test_a_run_of_a_map_with_a_wrong_number_is_left_out_and_told(tmp_path, caplog):
    Key, open_journal = RUNS.Key, SEARCH.open_journal
    file, key = tmp_path / "runs.jsonl", Key(1, 2, origin=(0, 3))
    record = RUNS.RunRecord(REGIMES.Regime.SMOOTH, radius=0.5)
    journal = open_journal(tmp_path, SETUP)
    for one in (key, Key(4, 4)):
        journal.add((one, record))
    assert open_journal(tmp_path, SETUP).results == [(key, ANY), (Key(4, 4), ANY)]
    file.write_bytes(file.read_bytes().replace(b'"radius":0.5', b'"radius":"0.5"', 1))
    assert not caplog.messages
    assert open_journal(tmp_path, SETUP).results == [(Key(4, 4), ANY)]
    assert caplog.messages == [f"{file}: 1 line that is no result is left out; what it was of is computed again"]
