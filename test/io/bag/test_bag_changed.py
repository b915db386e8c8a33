# SPDX-License-Identifier: Apache-2.0
"""A file that another program changes while it is recorded: noticed at the next flush, told, and gone on after."""

import os
import shutil

import pytest

from drill_twin.core.errors import BagError
from drill_twin.io.bag.reader import Bag
from drill_twin.io.bag.writer import BagWriter


def cut(file):
    os.truncate(file, 3000)


def replace(file):
    file.with_name("other").write_bytes(b"other")
    file.with_name("other").replace(file)


def append(file):
    with file.open("ab") as stream:
        stream.write(b"more")


CHANGES = {
    "found it cut to": cut,
    "bytes": lambda file: os.truncate(file, 0),
    "found it removed": os.remove,
    "found another file in its place": replace,
    "found 4 bytes of another program in it": append,
}


@pytest.mark.parametrize("said", CHANGES)
def test_a_file_that_is_changed_is_told_and_followed_by_another(said, tmp_path, messages, scene):
    half = len(messages) // 2
    writer = BagWriter(tmp_path / "run_0", flush_interval=0.0)
    for row in messages[:half]:
        writer.write(*row)
    CHANGES[said](writer.file)
    for row in messages[half:]:
        writer.write(*row)
    assert len(writer.damage) == 1
    assert writer.files == 2
    with pytest.raises(BagError, match=said) as caught:
        writer.close()
    assert f"up to {half}" in str(caught.value) or f"up to {half + 1}" in str(caught.value)
    bag = Bag(tmp_path / "run_0")
    read = list(bag.messages())
    assert set(messages[half + 1 :]) <= set(read)
    assert bag.scene() == scene
    if said != "found it removed":
        assert bag.damage or "4 bytes" in said


def test_a_change_after_the_last_message_is_noticed_too(tmp_path, messages):
    writer = BagWriter(tmp_path / "run_0")
    for row in messages:
        writer.write(*row)
    writer.flush()
    cut(writer.file)
    with pytest.raises(BagError, match="found it cut to"):
        writer.close()
    writer.close()  # a second call has no effect


def test_a_folder_that_is_removed_ends_the_recording(tmp_path, messages):
    writer = BagWriter(tmp_path / "run_0", flush_interval=0.0)
    writer.write(*messages[0])
    shutil.rmtree(tmp_path / "run_0")
    with pytest.raises(BagError, match="found it removed; record again: the folder is gone with 2 messages"):
        writer.write(*messages[1])
    writer.close()
    assert writer.lost == 2
