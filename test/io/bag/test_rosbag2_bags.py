# SPDX-License-Identifier: Apache-2.0
"""Bags as `ros2 bag record` of Jazzy writes them, after its source: sqlite3 of schema 4 and MCAP, split, compressed.

The tables, the records and the keys of `metadata.yaml` are those of rosbag2 0.26 (rosbag2_storage_sqlite3,
rosbag2_storage_mcap, rosbag2_storage/yaml.hpp); nothing in them is of this package but the messages.
"""

import sqlite3

import pytest
import yaml
import zstandard
from mcap.writer import CompressionType
from mcap.writer import Writer as McapWriter
from summaries import summarise

from drill_twin.io.bag.metadata import contract_topic
from drill_twin.io.bag.reader import Bag
from drill_twin.io.messages.topics import TWIN_SCENE

SCHEMA = """
PRAGMA journal_mode=MEMORY; PRAGMA synchronous=OFF;
CREATE TABLE schema(schema_version INTEGER PRIMARY KEY,ros_distro TEXT NOT NULL);
CREATE TABLE metadata(id INTEGER PRIMARY KEY,metadata_version INTEGER NOT NULL,metadata TEXT NOT NULL);
CREATE TABLE topics(id INTEGER PRIMARY KEY,name TEXT NOT NULL,type TEXT NOT NULL,serialization_format TEXT NOT NULL,
  offered_qos_profiles TEXT NOT NULL,type_description_hash TEXT NOT NULL);
CREATE TABLE message_definitions(id INTEGER PRIMARY KEY,topic_type TEXT NOT NULL,encoding TEXT NOT NULL,
  encoded_message_definition TEXT NOT NULL,type_description_hash TEXT NOT NULL);
CREATE TABLE messages(id INTEGER PRIMARY KEY,topic_id INTEGER NOT NULL,timestamp INTEGER NOT NULL, data BLOB NOT NULL);
CREATE INDEX timestamp_idx ON messages (timestamp ASC);
INSERT INTO schema (schema_version, ros_distro) VALUES (4, 'jazzy');
"""
UNKNOWN_QOS = {  # what the graph tells a recorder: history unknown, depth 0
    "history": "unknown",
    "depth": 0,
    "reliability": "reliable",
    "durability": "volatile",
    "deadline": {"sec": 9223372036, "nsec": 854775807},
    "lifespan": {"sec": 9223372036, "nsec": 854775807},
    "liveliness": "automatic",
    "liveliness_lease_duration": {"sec": 9223372036, "nsec": 854775807},
    "avoid_ros_namespace_conventions": False,
}


def information(storage, parts, names, mode=""):
    """Content of metadata.yaml, version 9."""
    rows = [row for part in parts for row in part]
    topics = [contract_topic(name) for name in dict.fromkeys(row[0] for row in rows)]

    def times(part):
        return {
            "starting_time": {"nanoseconds_since_epoch": part[0][1]},
            "duration": {"nanoseconds": part[-1][1] - part[0][1]},
        }

    return {
        "rosbag2_bagfile_information": {
            "version": 9,
            "storage_identifier": storage,
            **times(rows),
            "message_count": len(rows),
            "topics_with_message_count": [
                {
                    "topic_metadata": {
                        "name": topic.name,
                        "type": topic.type_name,
                        "serialization_format": "cdr",
                        "offered_qos_profiles": [UNKNOWN_QOS],
                        "type_description_hash": topic.type_hash,
                    },
                    "message_count": sum(row[0] == topic.name for row in rows),
                }
                for topic in topics
            ],
            "compression_format": "zstd" if mode else "",
            "compression_mode": mode,
            "relative_file_paths": names,
            "files": [
                {"path": name, **times(part), "message_count": len(part)}
                for name, part in zip(names, parts, strict=True)
            ],
            "custom_data": None,
            "ros_distro": "jazzy",
        }
    }


def write_sqlite(file, rows, metadata):
    database = sqlite3.connect(file)
    database.executescript(SCHEMA)
    numbers = {}
    for topic in (contract_topic(name) for name in dict.fromkeys(row[0] for row in rows)):
        qos = yaml.safe_dump([UNKNOWN_QOS], sort_keys=False)
        cursor = database.execute(
            "INSERT INTO topics(name, type, serialization_format, offered_qos_profiles, type_description_hash) "
            "VALUES (?, ?, 'cdr', ?, ?)",
            (topic.name, topic.type_name, qos, topic.type_hash),
        )
        numbers[topic.name] = cursor.lastrowid
        database.execute(
            "INSERT INTO message_definitions (topic_type, encoding, encoded_message_definition, type_description_hash) "
            "VALUES (?, 'ros2msg', ?, ?)",
            (topic.type_name, topic.definition, topic.type_hash),
        )
    for name, stamp, raw in rows:
        database.execute(
            "INSERT INTO messages (timestamp, topic_id, data) VALUES (?, ?, ?);", (stamp, numbers[name], raw)
        )
    if metadata:
        database.execute("INSERT INTO metadata (metadata_version, metadata) VALUES (9, ?)", (yaml.safe_dump(metadata),))
    database.commit()
    database.close()


def write_mcap(file, rows, metadata):
    with file.open("wb") as stream:
        writer = McapWriter(stream, compression=CompressionType.NONE, chunk_size=786_432)
        writer.start(profile="ros2", library="libmcap 1.4.0")
        channels, schemas = {}, {}
        for topic in (contract_topic(name) for name in dict.fromkeys(row[0] for row in rows)):
            if topic.type_name not in schemas:
                schemas[topic.type_name] = writer.register_schema(
                    topic.type_name, "ros2msg", topic.definition.encode("utf-8")
                )
            about = {
                "offered_qos_profiles": yaml.safe_dump([UNKNOWN_QOS], sort_keys=False),
                "topic_type_hash": topic.type_hash,
            }
            channels[topic.name] = writer.register_channel(topic.name, "cdr", schemas[topic.type_name], about)
        for name, stamp, raw in rows:
            writer.add_message(channels[name], stamp, raw, stamp)
        if metadata:
            content = yaml.safe_dump(metadata["rosbag2_bagfile_information"])
            writer.add_metadata("rosbag2", {"serialized_metadata": content})
        writer.finish()


@pytest.fixture
def record(tmp_path):
    """A bag as `ros2 bag record -s STORAGE --max-bag-size ... [--compression-mode MODE]` leaves it."""

    def write(rows, storage, mode="", parts=3, killed=False):
        folder = tmp_path / f"rosbag2_{storage}_{mode}_{parts}"
        folder.mkdir()
        length = -(-len(rows) // parts)
        pieces = [rows[k : k + length] for k in range(0, len(rows), length)]
        suffix = {"sqlite3": ".db3", "mcap": ".mcap"}[storage]
        names = [f"{folder.name}_{k}{suffix}" for k in range(len(pieces))]
        pack = zstandard.ZstdCompressor().compress
        kept = [name + ".zstd" if mode == "FILE" else name for name in names]
        about = information(storage, pieces, kept, mode)
        for name, piece in zip(names, pieces, strict=True):
            content = [(topic, stamp, pack(raw)) for topic, stamp, raw in piece] if mode == "MESSAGE" else piece
            writer = write_sqlite if storage == "sqlite3" else write_mcap
            writer(folder / name, content, None if killed else about)
            if mode == "FILE":
                (folder / f"{name}.zstd").write_bytes(pack((folder / name).read_bytes()))
                (folder / name).unlink()
        if not killed:
            (folder / "metadata.yaml").write_text(yaml.safe_dump(about, sort_keys=False), "utf-8")
        return folder

    return write


@pytest.mark.parametrize("storage", ["sqlite3", "mcap"])
@pytest.mark.parametrize("mode", ["", "MESSAGE", "FILE"])
def test_bags_of_ros2_bag_record_are_read(record, messages, scene, storage, mode):
    rows = sorted(messages, key=lambda row: row[1])
    bag = Bag(record(rows, storage, mode))
    assert sorted(bag.messages()) == sorted(rows)
    assert (bag.message_count, bag.start, bag.end) == (len(rows), rows[0][1], rows[-1][1])
    assert not bag.truncated
    assert bag.scene() == scene
    assert bag.topics[TWIN_SCENE].type_hash == contract_topic(TWIN_SCENE).type_hash


@pytest.mark.parametrize("storage", ["sqlite3", "mcap"])
def test_a_bag_of_a_killed_ros2_bag_record_is_read(record, messages, storage):
    """It has no metadata.yaml, and no metadata in its files."""
    rows = sorted(messages, key=lambda row: row[1])
    assert sorted(Bag(record(rows, storage, killed=True)).messages()) == sorted(rows)


@pytest.mark.parametrize("storage", ["sqlite3", "mcap"])
def test_findings_are_those_of_our_own_bag(record, bench_run, storage):
    """The whole analysis, of a bag that only the real recorder wrote: times of reception, several files."""
    began = 1_790_000_000_000_000_000
    rows = [(topic, began + stamp, raw) for topic, stamp, raw in Bag(bench_run.bag).messages()]
    ours, theirs = summarise(bench_run.bag), summarise(record(rows, storage))
    assert theirs["onset_s"] is not None
    assert ours == theirs
