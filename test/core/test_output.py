# SPDX-License-Identifier: Apache-2.0
"""Files written as a whole: what a full disk, a kill and other kinds of files leave."""

import os
import signal
import stat
import subprocess
import sys
import textwrap

import pytest

from drill_twin.core.errors import BagError
from drill_twin.core.files.output import PRIVATE, whole_file, write_whole
from drill_twin.report.figures.style import blank, save


def test_text_and_bytes_take_the_place_of_the_file_of_before(tmp_path):
    file = tmp_path / "map.json"
    write_whole(file, "first\n")
    write_whole(file, "Bohrstange \u00f8\n")
    assert file.read_bytes() == "Bohrstange \u00f8\n".encode()
    write_whole(file, b"\xff\x00")
    assert file.read_bytes() == b"\xff\x00"
    assert list(tmp_path.iterdir()) == [file]


def test_a_full_disk_leaves_the_file_of_before(small_disk):
    disk = small_disk(64 * 1024)
    file = disk / "map.json"
    write_whole(file, "before")
    with pytest.raises(OSError, match="No space left"):
        write_whole(file, b"x" * 200_000)
    assert file.read_text("utf-8") == "before"
    assert list(disk.iterdir()) == [file]
    with pytest.raises(OSError, match="No space left"):
        write_whole(disk / "new.json", b"x" * 200_000)
    assert list(disk.iterdir()) == [file]


def test_a_figure_on_a_full_disk_is_refused_in_a_sentence(small_disk):
    disk = small_disk(4 * 1024)  # a page of memory
    (disk / "full").write_bytes(b"x" * 4096)
    with pytest.raises(
        BagError,
        match=r"a\.png: expected a place to write the figure, found No space left on device; choose another place$",
    ):
        save(blank(5.0), disk / "a.png")
    assert list(disk.iterdir()) == [disk / "full"]


def test_a_result_on_a_full_disk_is_refused_by_the_command_in_a_sentence(small_disk):
    disk = small_disk(8 * 1024)
    command = [sys.executable, "-m", "drill_twin.cli", "scene", "schema", "--out", str(disk)]
    said = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (said.returncode, said.stdout) == (2, "")
    assert said.stderr.strip() == (
        f"drill-twin: error: {disk}/scene.schema.json: expected a place to write the file, found No space left on "
        "device; choose another place"
    )
    assert not list(disk.iterdir())


def test_a_kill_leaves_the_file_of_before(tmp_path):
    file = tmp_path / "map.json"
    write_whole(file, "before")
    text = f"""
        import os, signal
        from pathlib import Path
        from drill_twin.core.files.output import whole_file
        with whole_file(Path({str(file)!r})) as stream:
            stream.write(b"half")
            stream.flush()
            os.kill(os.getpid(), signal.SIGKILL)
    """
    assert subprocess.run([sys.executable, "-c", textwrap.dedent(text)], check=False).returncode == -signal.SIGKILL
    assert file.read_text("utf-8") == "before"


def test_an_error_in_the_block_leaves_the_file_of_before(tmp_path):
    file = tmp_path / "map.json"
    write_whole(file, "before")
    with pytest.raises(TypeError), whole_file(file) as stream:
        stream.writelines([b"half", "text"])
    assert file.read_text("utf-8") == "before"
    assert list(tmp_path.iterdir()) == [file]


def test_modes_are_those_of_the_file_of_before_or_less(tmp_path):
    before = os.umask(0o022)
    try:
        for name, mode in (("new", 0o666), ("private", PRIVATE), ("closed", 0o666)):
            (tmp_path / "closed").touch(0o640)
            write_whole(tmp_path / name, b"", mode)
    finally:
        os.umask(before)
    modes = {file.name: stat.S_IMODE(file.stat().st_mode) for file in tmp_path.iterdir()}
    assert modes == {"new": 0o644, "private": 0o600, "closed": 0o640}


def test_a_link_leads_to_the_new_file(tmp_path):
    (tmp_path / "real.json").write_text("before", "utf-8")
    (tmp_path / "link.json").symlink_to("real.json")
    write_whole(tmp_path / "link.json", "after")
    assert (tmp_path / "link.json").is_symlink()
    assert (tmp_path / "real.json").read_text("utf-8") == "after"


def test_folders_pipes_and_devices_are_not_replaced(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "folder").mkdir()
    (tmp_path / "device").symlink_to("/dev/null")
    for name in ("pipe", "folder", "device"):
        with pytest.raises(OSError, match="a folder, a pipe or a device there"):
            write_whole(tmp_path / name, "text")
    assert stat.S_ISCHR(os.stat("/dev/null").st_mode)  # noqa: PTH116  where the link leads
    assert sorted(file.name for file in tmp_path.iterdir()) == ["device", "folder", "pipe"]


def test_a_long_name_is_a_good_name(tmp_path):
    write_whole(tmp_path / ("n" * 255), "text")
    assert (tmp_path / ("n" * 255)).read_text("utf-8") == "text"
