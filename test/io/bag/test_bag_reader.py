# SPDX-License-Identifier: Apache-2.0
"""Bags of all storages are read; anything else raises an error that says what was found."""

import shutil

import pytest
from mcap.writer import CompressionType
from mcap.writer import Writer as McapWriter
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer

from drill_twin.core.errors import BagError
from drill_twin.io.bag.reader import Bag
from drill_twin.io.bag.writer import BagWriter
from drill_twin.io.messages.encode import encode_string
from drill_twin.io.messages.topics import MARKS_STATE, STRING_POSES, TOPICS, TWIN_SCENE
from drill_twin.io.messages.type_store import definition, typestore


def by_rosbags(folder, rows, storage=StoragePlugin.SQLITE3, compression=CompressionMode.NONE, types=None):
    """The rows, recorded by rosbags."""
    writer = Writer(folder, version=9, storage_plugin=storage)
    writer.set_compression(compression, CompressionFormat.ZSTD)
    with writer:
        connections = {}
        for name, stamp, raw in rows:
            if name not in connections:
                kind = (types or {}).get(name) or TOPICS[name].type_name
                connections[name] = writer.add_connection(name, kind, typestore=typestore())
            writer.write(connections[name], stamp, raw)
    return folder


def error_of(path):
    with pytest.raises(BagError) as caught:
        Bag(path)
    text = str(caught.value)
    assert "\n" not in text
    assert text.startswith(str(path))
    return text


def test_a_file_that_a_killed_writer_had_just_made_is_left_out(write_bag, messages):
    folder = write_bag("run_0", longest=0.2)
    (folder / "run_0_9.mcap").touch()
    bag = Bag(folder)
    assert list(bag.messages()) == messages
    assert bag.damage == ["run_0_9.mcap is empty: its writer was killed as it began"]


def test_it_says_what_it_holds(write_bag, messages, scene):
    bag = Bag(write_bag())
    assert bag.scene() == scene
    assert {name: topic.count for name, topic in bag.topics.items()} == {
        name: sum(row[0] == name for row in messages) for name in TOPICS
    }
    assert bag.last(STRING_POSES) == [raw for name, _, raw in messages if name == STRING_POSES][-1]
    assert list(bag.messages([MARKS_STATE])) == [row for row in messages if row[0] == MARKS_STATE]
    assert list(bag.messages([])) == []


def test_the_file_alone_will_do(write_bag, messages):
    folder = write_bag()
    (folder / "metadata.yaml").unlink()
    assert list(Bag(folder).messages()) == messages
    assert list(Bag(folder / "run_0.mcap").messages()) == messages


@pytest.mark.parametrize("text", ["{", "[1, 2]", "", "rosbag2_bagfile_information: 7"])
def test_broken_metadata_is_no_harm_to_mcap(write_bag, messages, text):
    folder = write_bag()
    (folder / "metadata.yaml").write_text(text)
    assert list(Bag(folder).messages()) == messages


@pytest.mark.parametrize(
    ("storage", "compression"),
    [
        (StoragePlugin.SQLITE3, CompressionMode.NONE),
        (StoragePlugin.SQLITE3, CompressionMode.MESSAGE),
        (StoragePlugin.SQLITE3, CompressionMode.FILE),
        (StoragePlugin.MCAP, CompressionMode.NONE),
        (StoragePlugin.MCAP, CompressionMode.STORAGE),
        (StoragePlugin.MCAP, CompressionMode.MESSAGE),
        (StoragePlugin.MCAP, CompressionMode.FILE),
    ],
)
def test_bags_of_other_recorders(tmp_path, messages, scene, storage, compression):
    bag = Bag(by_rosbags(tmp_path / "theirs", messages, storage, compression))
    assert sorted(bag.messages()) == sorted(messages)
    assert not bag.truncated
    assert (bag.start, bag.end, bag.message_count) == (0, 390_000_000, len(messages))
    assert bag.scene() == scene
    assert list(bag.messages([])) == []
    assert bag.topics[TWIN_SCENE].definition == definition(TOPICS[TWIN_SCENE].type_name)


def test_a_lone_db3_file(tmp_path, messages):
    folder = by_rosbags(tmp_path / "theirs", messages)
    (folder / "metadata.yaml").unlink()
    assert sorted(Bag(folder).messages()) == sorted(messages)
    assert sorted(Bag(folder / "theirs.db3").messages()) == sorted(messages)


@pytest.mark.parametrize("compression", [CompressionType.NONE, CompressionType.LZ4, None])
def test_other_ways_to_write_mcap(tmp_path, messages, compression):
    """Chunks that are not compressed, lz4, and no chunks at all."""
    with (tmp_path / "run.mcap").open("wb") as stream:
        writer = McapWriter(
            stream, compression=compression or CompressionType.NONE, use_chunking=compression is not None
        )
        writer.start()
        kind = TOPICS[STRING_POSES].type_name
        schema = writer.register_schema(kind, "ros2msg", definition(kind).encode())
        channel = writer.register_channel(STRING_POSES, "cdr", schema)
        other = writer.register_channel("/json", "json", schema)
        writer.add_message(other, 1, b"{}", 1)
        for k in range(5):
            writer.add_message(channel, k, bytes([k]), k)
        writer.finish()
    bag = Bag(tmp_path / "run.mcap")
    assert list(bag.messages()) == [(STRING_POSES, k, bytes([k])) for k in range(5)]
    assert not bag.truncated
    assert list(bag.topics) == [STRING_POSES]


def test_a_split_bag_is_read_in_order(tmp_path, messages):
    """rosbag2 splits long recordings into run_0.mcap, run_1.mcap, ... run_10.mcap."""
    folder = tmp_path / "run"
    folder.mkdir()
    parts = [messages[k::11] for k in range(11)]
    for k, part in enumerate(parts):
        with BagWriter(tmp_path / f"part_{k}") as writer:
            for row in part:
                writer.write(*row)
        shutil.copy(writer.file, folder / f"run_{k}.mcap")
    bag = Bag(folder)
    assert list(bag.messages()) == [row for part in parts for row in part]
    assert bag.message_count == len(messages)
    assert not bag.truncated


def test_nothing_there(tmp_path):
    assert "found nothing there" in error_of(tmp_path / "missing_0")


def test_an_empty_folder(tmp_path):
    assert "expected a bag (.mcap or .db3) in this folder, found nothing in it" in error_of(tmp_path)


def test_a_folder_of_something_else(tmp_path):
    (tmp_path / "notes.txt").write_text("not a bag")
    assert "found notes.txt; not a bag" in error_of(tmp_path)


def test_a_bag_one_level_deeper_is_pointed_to(write_bag, tmp_path):
    folder = write_bag()
    assert error_of(tmp_path).endswith(f"found a bag a level deeper; name {folder}")


@pytest.mark.parametrize("name", ["run_0.mcap", "run_0.db3", "notes.txt", "no_suffix"])
@pytest.mark.parametrize("content", [b"", b"x", b"PNG\r\n" * 5000])
def test_garbage(tmp_path, name, content):
    file = tmp_path / name
    file.write_bytes(content)
    text = error_of(file)
    assert "expected" in text
    assert "found" in text


def test_an_empty_bag(tmp_path):
    with BagWriter(tmp_path / "run_0"):
        pass
    assert error_of(tmp_path / "run_0").endswith("expected messages, found none; record it again")


def test_a_bag_killed_at_birth(tmp_path):
    writer = BagWriter(tmp_path / "run_0")
    assert "found none (run_0.mcap ends in the middle of a record, at byte" in error_of(tmp_path / "run_0")
    writer.close()


def test_an_empty_sqlite_bag(tmp_path):
    assert "found none" in error_of(by_rosbags(tmp_path / "theirs", []))


def test_a_bag_of_another_package(tmp_path):
    raw = encode_string("hello")
    types = {"/chatter": "std_msgs/msg/String", "/clock": "rosgraph_msgs/msg/Clock"}
    folder = by_rosbags(tmp_path / "theirs", [("/chatter", 1, raw), ("/clock", 2, bytes(12))], types=types)
    text = error_of(folder)
    assert "found only /chatter (std_msgs/msg/String), /clock (rosgraph_msgs/msg/Clock)" in text
    assert "another package" in text


def test_our_names_with_other_types(tmp_path):
    folder = by_rosbags(
        tmp_path / "theirs", [(STRING_POSES, 1, encode_string(""))], types={STRING_POSES: "std_msgs/msg/String"}
    )
    assert "expected /string/poses as geometry_msgs/msg/PoseArray, found std_msgs/msg/String" in error_of(folder)


def test_a_bag_that_vanishes_while_it_is_read(write_bag):
    folder = write_bag()
    bag = Bag(folder)
    shutil.rmtree(folder)
    with pytest.raises(BagError, match="expected a readable bag, found No such file"):
        list(bag.messages())


def test_a_bag_without_a_scene(write_bag, messages):
    bag = Bag(write_bag(rows=[row for row in messages if row[0] != TWIN_SCENE]))
    with pytest.raises(BagError, match="expected the scene on /twin/scene"):
        bag.scene()


def test_metadata_that_names_missing_files(tmp_path, messages):
    folder = by_rosbags(tmp_path / "theirs", messages)
    shutil.move(folder / "theirs.db3", folder / "moved.db3")
    bag = Bag(folder)
    assert bag.damage == ["theirs.db3 is missing"]
    assert len(list(bag.messages())) == len(messages)
