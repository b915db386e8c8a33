# SPDX-License-Identifier: Apache-2.0
"""Files, schemas, metadata and QoS of a bag are those that the tools of ROS expect."""

import errno
import os
import resource
import signal
import subprocess
import sys
from dataclasses import replace

import pytest
import yaml
from rosbags.highlevel import AnyReader
from rosbags.interfaces import Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime
from rosbags.rosbag2 import Reader, StoragePlugin, Writer

from drill_twin.core.errors import BagError
from drill_twin.io.bag.metadata import contract_topic
from drill_twin.io.bag.reader import Bag
from drill_twin.io.bag.writer import BagWriter
from drill_twin.io.messages.topics import STRING_POSES, TOPICS, TWIN_SCENE
from drill_twin.io.messages.type_store import definition, type_hash, typestore


def metadata_of(folder):
    return yaml.safe_load((folder / "metadata.yaml").read_text())["rosbag2_bagfile_information"]


def written_by_rosbags(folder, messages):
    """The same messages, recorded by rosbags with the QoS of the contract."""
    forever = QosTime(9223372036, 854775807)
    with Writer(folder, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        connections = {
            topic.name: writer.add_connection(
                topic.name,
                topic.type_name,
                typestore=typestore(),
                offered_qos_profiles=[
                    Qos(
                        QosHistory.KEEP_LAST,
                        topic.depth,
                        QosReliability.RELIABLE,
                        QosDurability.TRANSIENT_LOCAL if topic.latched else QosDurability.VOLATILE,
                        forever,
                        forever,
                        QosLiveliness.AUTOMATIC,
                        forever,
                        False,
                    )
                ],
            )
            for topic in TOPICS.values()
        }
        for name, stamp, raw in messages:
            writer.write(connections[name], stamp, raw)
    return folder


@pytest.mark.parametrize("limit", [{"largest": 40_000.0}, {"longest": 0.1}], ids=["size", "time"])
@pytest.mark.parametrize("name", ["run", "run_0"])
def test_a_split_bag_is_one_bag(write_bag, messages, name, limit):
    """For our reader, and for one that knows only rosbag2's metadata."""
    folder = write_bag(name, flush_interval=0.0, **limit)
    files = sorted(folder.glob("*.mcap"))
    assert len(files) >= 3
    assert {file.name for file in files} == {"run_0.mcap"} | {
        f"{name}_{k}.mcap" for k in range(1, len(files))
    }  # names that `ros2 bag reindex` finds, in this order
    bag = Bag(folder)
    assert not bag.truncated
    assert list(bag.messages()) == messages
    information = metadata_of(folder)
    assert information["relative_file_paths"] == [file["path"] for file in information["files"]]
    assert set(information["relative_file_paths"]) == {file.name for file in files}
    assert sum(file["message_count"] for file in information["files"]) == len(messages)
    with Reader(folder) as reader:
        assert reader.message_count == len(messages)
        assert sorted((c.topic, stamp, raw) for c, stamp, raw in reader.messages()) == sorted(messages)
        assert {c.topic: c.digest for c in reader.connections} == {t: type_hash(TOPICS[t].type_name) for t in TOPICS}
        assert all(c.ext.offered_qos_profiles for c in reader.connections)
    for file in information["files"]:
        assert file["starting_time"]["nanoseconds_since_epoch"] >= 0
        assert file["duration"]["nanoseconds"] <= max(0.1e9, 1.0e9 * ("largest" in limit))
    assert information["duration"]["nanoseconds"] == messages[-1][1]


def test_every_message_comes_back(write_bag, messages):
    bag = Bag(write_bag())
    assert list(bag.messages()) == messages
    assert not bag.truncated
    assert bag.message_count == len(messages)
    assert (bag.start, bag.end) == (0, 390_000_000)


def test_rosbags_reads_it(write_bag, messages):
    with Reader(write_bag()) as reader:
        found = [(connection.topic, stamp, bytes(raw)) for connection, stamp, raw in reader.messages()]
        assert {c.topic: c.msgtype for c in reader.connections} == {t.name: t.type_name for t in TOPICS.values()}
        assert reader.duration == 390_000_001  # rosbags counts the last nanosecond in
    assert sorted(found) == sorted(messages)


def test_rosbags_reads_the_file_alone(write_bag, messages):
    with Reader(write_bag() / "run_0.mcap") as reader:
        assert reader.message_count == len(messages)
        latched = next(c for c in reader.connections if c.topic == TWIN_SCENE)
        assert latched.ext.offered_qos_profiles[0].durability == QosDurability.TRANSIENT_LOCAL


def test_the_reader_of_rosbags_that_asks_for_no_types_decodes_every_message(write_bag, messages):
    """`rosbags.highlevel` takes the types from the bag, as a user's script does."""
    with AnyReader([write_bag()]) as reader:
        decoded = [(c.topic, reader.deserialize(raw, c.msgtype)) for c, _, raw in reader.messages()]
        assert all(c.ext.offered_qos_profiles for c in reader.connections)
    assert len(decoded) == len(messages)
    for topic, message in decoded:
        assert message.__msgtype__ == TOPICS[topic].type_name


def test_rosbag2_finds_each_key_that_its_reader_asks_for(write_bag, messages):
    """Jazzy's `rosbag2_storage/yaml.hpp` decodes metadata.yaml so: a key that is absent or of another kind ends it."""
    information = metadata_of(write_bag())
    kinds = {"version": int, "storage_identifier": str, "message_count": int, "compression_format": str,
             "compression_mode": str, "ros_distro": str, "relative_file_paths": list, "files": list}  # fmt: skip
    assert {name: type(information[name]) for name in kinds} == kinds
    assert information["version"] == 9
    assert information["custom_data"] is None or all(
        isinstance(text, str) for pair in information["custom_data"].items() for text in pair
    )
    for part in (information, *information["files"]):
        assert part["starting_time"]["nanoseconds_since_epoch"] >= 0
        assert part["duration"]["nanoseconds"] >= 0
        assert part["message_count"] == len(messages)
    forever = {"sec": 9223372036, "nsec": 854775807}
    for topic in information["topics_with_message_count"]:
        about = topic["topic_metadata"]
        row = TOPICS[about["name"]]
        assert (about["type"], about["serialization_format"]) == (row.type_name, "cdr")
        assert about["type_description_hash"].startswith("RIHS01_")
        assert about["offered_qos_profiles"] == [
            {
                "history": "keep_last",
                "depth": row.depth,
                "reliability": "reliable",
                "durability": "transient_local" if row.latched else "volatile",
                "deadline": forever,
                "lifespan": forever,
                "liveliness": "automatic",
                "liveliness_lease_duration": forever,
                "avoid_ros_namespace_conventions": False,
            }
        ]


def test_every_message_is_decoded_by_the_schemas_in_the_file(write_bag, messages):
    """mcap-ros2-support knows nothing of ROS but what the file says."""
    from mcap.reader import make_reader
    from mcap_ros2.decoder import DecoderFactory

    with (write_bag() / "run_0.mcap").open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        assert reader.get_header().profile == "ros2"
        decoded = [(channel, message) for _, channel, _, message in reader.iter_decoded_messages()]
        kept = {record.name: record.metadata for record in reader.iter_metadata()}
        statistics = reader.get_summary().statistics
    assert len(decoded) == len(messages) == statistics.message_count
    poses = next(message for channel, message in decoded if channel.topic == STRING_POSES)
    assert len(poses.poses) == 11
    assert poses.header.frame_id == "hole"
    for channel, _ in decoded:
        assert channel.metadata["topic_type_hash"] == type_hash(TOPICS[channel.topic].type_name)
        assert yaml.safe_load(channel.metadata["offered_qos_profiles"])[0]["reliability"] == "reliable"
    assert yaml.safe_load(kept["rosbag2"]["serialized_metadata"])["message_count"] == len(messages)


def test_metadata_is_that_of_rosbags_key_by_key(write_bag, messages, tmp_path):
    ours = metadata_of(write_bag())
    theirs = metadata_of(written_by_rosbags(tmp_path / "theirs" / "run_0", messages))
    assert ours.keys() == theirs.keys()
    differing = {key for key in ours if ours[key] != theirs[key]}
    assert differing == {"custom_data", "ros_distro"}  # labels: who wrote it, for which ROS
    assert ours["ros_distro"] == "jazzy"


def test_schemas_are_those_of_rosbags(write_bag, messages, tmp_path):
    from mcap.reader import make_reader

    def summary(folder):
        with (folder / "run_0.mcap").open("rb") as stream:
            found = make_reader(stream).get_summary()
        schemas = {s.name: (s.encoding, s.data) for s in found.schemas.values()}
        channels = {c.topic: (c.message_encoding, found.schemas[c.schema_id].name) for c in found.channels.values()}
        return schemas, channels

    assert summary(write_bag()) == summary(written_by_rosbags(tmp_path / "theirs" / "run_0", messages))


def test_no_yaml_references(write_bag):
    text = (write_bag() / "metadata.yaml").read_text()
    assert "&" not in text
    assert "*" not in text


@pytest.mark.parametrize(("folder", "file"), [("run_0", "run_0.mcap"), ("run", "run_0.mcap"), ("a_12", "a_12.mcap")])
def test_file_names_end_in_a_number_for_reindex(tmp_path, folder, file):
    with BagWriter(tmp_path / "deep" / "er" / folder) as writer:
        assert writer.file == tmp_path / "deep" / "er" / folder / file
    assert writer.file.exists()


def test_another_qos_is_kept(tmp_path):
    best_effort = {
        **contract_topic(STRING_POSES).qos[0],
        "reliability": "best_effort",
        "history": "unknown",
        "depth": 0,
    }
    with BagWriter(tmp_path / "run_0", topics=[replace(contract_topic(STRING_POSES), qos=[best_effort])]) as writer:
        writer.write(STRING_POSES, 1, b"\0\1\0\0")
    assert metadata_of(writer.folder)["topics_with_message_count"][0]["topic_metadata"]["offered_qos_profiles"] == [
        best_effort
    ]
    assert list(Bag(writer.folder).topics[STRING_POSES].qos) == [best_effort]


def test_an_exception_in_the_run_leaves_a_whole_bag(tmp_path, messages):
    writer = BagWriter(tmp_path / "run_0")

    def run():
        with writer:
            writer.write(*messages[0])
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        run()
    assert (writer.folder / "metadata.yaml").exists()
    assert list(Bag(writer.folder).messages()) == messages[:1]


def test_closing_twice_is_closing(write_bag, tmp_path, messages):
    writer = BagWriter(tmp_path / "run_0")
    writer.write(*messages[0])
    writer.close()
    writer.close()
    with pytest.raises(BagError, match="found it closed"):
        writer.write(*messages[0])


def test_an_existing_folder_is_left_alone(tmp_path):
    (tmp_path / "run_0").mkdir()
    (tmp_path / "run_0" / "precious").write_text("data")
    with pytest.raises(BagError, match=r"run_0: expected a new folder for the bag, found a folder that exists"):
        BagWriter(tmp_path / "run_0")
    assert [file.name for file in (tmp_path / "run_0").iterdir()] == ["precious"]


def test_a_place_that_cannot_be_written(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(BagError, match="expected a place to write the bag, found Not a directory"):
        BagWriter(tmp_path / "file" / "run_0")


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_a_folder_without_permission(tmp_path):
    tmp_path.chmod(0o500)
    with pytest.raises(BagError, match="Permission denied"):
        BagWriter(tmp_path / "run_0")


def test_a_topic_must_be_announced(tmp_path, messages):
    with BagWriter(tmp_path / "run_0", topics=[STRING_POSES]) as writer:
        with pytest.raises(BagError, match=r"expected one of /string/poses, found /twin/scene"):
            writer.write(*messages[0])
        writer.add_topic(contract_topic(TWIN_SCENE))
        writer.add_topic(contract_topic(TWIN_SCENE))  # once more is no harm
        writer.write(*messages[0])
        other = contract_topic(STRING_POSES)
        other.type_name = "std_msgs/msg/String"
        with pytest.raises(BagError, match="throughout"):
            writer.add_topic(other)
    assert writer.counts == {STRING_POSES: 0, TWIN_SCENE: 1}
    assert Bag(writer.folder).topics[TWIN_SCENE].definition == definition(TOPICS[TWIN_SCENE].type_name)


def test_a_negative_stamp_is_refused(tmp_path, messages):
    name, _, raw = messages[0]
    with BagWriter(tmp_path / "run_0") as writer, pytest.raises(BagError, match="0 ns or later"):
        writer.write(name, -1, raw)


FULL_DISK = """
import sys
from drill_twin.io.bag.writer import BagWriter
from drill_twin.core.errors import BagError
try:
    with BagWriter(sys.argv[1], flush_interval=0.0) as writer:
        for k in range(2000):
            writer.write("/twin/scene", k, k.to_bytes(4, "big") * 100)
except BagError as error:
    sys.exit(str(error))
"""


def limit_file_size():
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (60_000, 60_000))


def test_a_full_disk_is_one_clear_error_and_loses_nothing_before_it(tmp_path):
    """A real process runs into a real limit of file size."""
    process = subprocess.run(
        [sys.executable, "-c", FULL_DISK, tmp_path / "run_0"],
        capture_output=True, text=True, check=False, preexec_fn=limit_file_size,  # noqa: PLW1509  single-threaded
    )  # fmt: skip
    assert process.returncode == 1
    lines = process.stderr.strip().splitlines()
    assert len(lines) == 1, process.stderr
    assert "run_0.mcap: expected to go on writing the bag, found " + os.strerror(errno.EFBIG) in lines[0]
    bag = Bag(tmp_path / "run_0")
    stamps = [stamp for _, stamp, _ in bag.messages()]
    assert stamps == list(range(len(stamps)))
    assert len(stamps) > 100


def test_a_full_disk_leaves_whole_messages_and_the_number_of_those_lost(small_disk):
    folder = small_disk(256 * 1024) / "run_0"
    writer, done = BagWriter(folder, flush_interval=0.0), []
    stamps = [1_000_000_000 + k * 1_000_000 for k in range(200)]

    def write_until_full():
        for written, stamp in enumerate(stamps):
            writer.write("/twin/scene", stamp, os.urandom(5000))  # which cannot be compressed
            done.append(written)

    with pytest.raises(BagError, match="expected to go on writing the bag, found No space left on device") as failed:
        write_until_full()
    bag = Bag(folder)
    written = len(done)
    assert [stamp for _, stamp, _ in bag.messages()] == stamps[:written]
    assert written > 20
    assert writer.lost == 1
    said = str(failed.value)
    assert f"messages are lost, 1 so far; {written} earlier messages can be read" in said
    assert not [text for text in bag.damage if "cut" in text or "damaged" in text], bag.damage
    writer.close()  # a second end has no effect


def test_topics_of_another_bag_can_be_given(write_bag, messages, tmp_path):
    """Their counts are those of the new bag, and the other bag keeps its own."""
    bag = Bag(write_bag())
    with BagWriter(tmp_path / "copy_0", topics=bag.topics.values()) as writer:
        writer.write(*messages[0])
    assert Bag(writer.folder).message_count == sum(writer.counts.values()) == 1
    assert bag.message_count == len(messages)
