# SPDX-License-Identifier: Apache-2.0
"""A window of a complete bag is read by its index: the same samples as of the whole bag, a small part of its bytes."""

import shutil
import sqlite3
from pathlib import Path

import numpy as np
import pytest
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from drill_twin.core.rig_channels import RIG_JOINTS
from drill_twin.io.bag import file_writer
from drill_twin.io.bag.reader import Bag
from drill_twin.io.bag.reading import mcap_records
from drill_twin.io.bag.reading.mcap_records import read_index
from drill_twin.io.bag.writer import BagWriter
from drill_twin.io.messages.cdr import JointStateTemplate
from drill_twin.io.messages.topics import RIG_STATE, TWIN_SCENE
from drill_twin.report.rig_table import read_rig
from drill_twin.report.selection import Selection

SECONDS, RATE, LATER = 400, 100, 1_700_000_000
FOUR = (0.0, 0.0, 0.0, 0.0)


def write(folder, scenes=1):
    """Rig states of 400 s, recorded 1.7e9 s later than they are stamped, with latched scenes."""
    template, random = JointStateTemplate(RIG_JOINTS), np.random.default_rng(1)
    text = bytes.fromhex("00010000") + b"\x04\0\0\0a: \0"
    with BagWriter(folder, flush_interval=1e9) as bag:
        for k in range(SECONDS * RATE):
            if k % (SECONDS * RATE // scenes) == 0:
                bag.write(TWIN_SCENE, k * 10_000_000 + LATER * 10**9, text)
            stamp = k * 10_000_000
            bag.write(RIG_STATE, stamp + LATER * 10**9, template.fill(stamp, random.random(4), FOUR, FOUR))
    return folder


@pytest.fixture(scope="module", autouse=True)
def small_chunks():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(file_writer, "_CHUNK_SIZE", 16 * 1024)
        yield


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    """The bag of one run; for reading only."""
    return write(tmp_path_factory.mktemp("window") / "bag")


@pytest.fixture
def copy(bag, tmp_path):
    """A copy of it, to be damaged."""
    return shutil.copytree(bag, tmp_path / "bag")


@pytest.fixture
def decompressed(monkeypatch):
    """Sizes of the chunks that are decompressed."""
    sizes, real = [], mcap_records.decompressed

    def counted(kind, data, size):
        sizes.append(size)
        return real(kind, data, size)

    monkeypatch.setattr(mcap_records, "decompressed", counted)
    return sizes


@pytest.mark.slow
def test_a_window_takes_its_part_of_the_bytes_and_gives_the_same_samples(bag, decompressed):
    whole = Bag(bag)
    size = sum(decompressed)
    decompressed.clear()
    rig, _ = read_rig(bag, Selection(begin=300.0, end=310.0))
    assert sum(decompressed) < 0.2 * size  # 10 s of 400 s, read three times, and the search
    assert rig.time[[0, -1]].tolist() == [300.0, 310.0]
    assert len(rig) == 10 * RATE + 1
    window = Bag(bag, window=(300.0, 310.0))
    assert {name: topic.count for name, topic in window.topics.items()} == {
        name: topic.count for name, topic in whole.topics.items()
    }
    assert (window.start, window.end) == (whole.start, whole.end)
    assert window.scene() == whole.scene() == "a: "
    told = [stamp for topic, stamp, _ in whole.messages() if 300.0 <= stamp * 1e-9 - LATER <= 310.0]
    assert set(told) <= {stamp for _, stamp, _ in window.messages()}
    assert not window.damage


@pytest.mark.slow
def test_open_ends_and_windows_beside_the_bag(bag):
    for begin, end, first, last in ((-np.inf, 2.0, 0.0, 2.0), (398.0, np.inf, 398.0, 399.99)):
        assert read_rig(bag, Selection(begin=begin, end=end))[0].time[[0, -1]].tolist() == [first, last]
    assert len(list(Bag(bag, window=(1000.0, 1001.0)).messages((RIG_STATE,)))) < 0.2 * SECONDS * RATE


@pytest.mark.slow
@pytest.mark.parametrize("what", ["cut", "checksum", "two runs"])
def test_a_bag_without_an_index_to_trust_is_read_whole(copy, tmp_path, decompressed, what):
    bag = write(tmp_path / "two", scenes=2) if what == "two runs" else copy
    file = next(bag.glob("*.mcap"))
    data = bytearray(file.read_bytes())
    if what == "cut":
        del data[-100:]
    elif what == "checksum":
        data[-60] ^= 1
    file.write_bytes(data)
    decompressed.clear()
    assert len(read_rig(bag, Selection(begin=300.0, end=310.0))[0]) == 10 * RATE + 1
    assert sum(decompressed) > 0.9 * len(data)


@pytest.mark.slow
def test_damage_in_a_window_is_told(copy):
    file = copy / "bag_0.mcap"
    with file.open("rb") as stream:
        chunks = read_index(stream).chunks
    data = bytearray(file.read_bytes())
    data[chunks[len(chunks) // 2][2][0] + 200] ^= 1
    file.write_bytes(data)
    found = Bag(copy, window=(150.0, 250.0))
    assert "damaged chunk at byte" in found.damage[0]
    assert not Bag(copy, window=(0.0, 10.0)).damage


def bytes_read(function, *arguments):
    """Result of a function, and the bytes that this process read in it."""

    def count():
        return int(Path("/proc/self/io").read_text().split()[1])

    before = count()
    return function(*arguments), count() - before


@pytest.fixture(scope="module")
def sqlite_bag(bag, tmp_path_factory):
    """The same messages as rosbag2 keeps them in SQLite."""
    folder = tmp_path_factory.mktemp("sqlite")
    whole, store = Bag(bag), get_typestore(Stores.ROS2_JAZZY)
    with Writer(folder / "sql", version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
        topics = {name: writer.add_connection(name, of.type_name, typestore=store) for name, of in whole.topics.items()}
        for name, stamp, raw in whole.messages():
            writer.write(topics[name], stamp, raw)
    return folder / "sql"


@pytest.mark.slow
def test_a_window_of_an_sqlite_bag_takes_its_part_of_the_bytes_and_gives_the_same_samples(sqlite_bag):
    size = next(sqlite_bag.glob("*.db3")).stat().st_size
    (rig, _), taken = bytes_read(read_rig, sqlite_bag, Selection(begin=300.0, end=310.0))
    assert taken < 0.2 * size  # 10 s of 400 s, read twice, the index of times for the count, and the search
    whole, _ = read_rig(sqlite_bag, Selection())
    wanted = (whole.time >= 300.0) & (whole.time <= 310.0)
    assert rig.time.tolist() == whole.time[wanted].tolist()
    assert rig.bit_speed.tolist() == whole.bit_speed[wanted].tolist()
    assert rig.time[[0, -1]].tolist() == [300.0, 310.0]
    for begin, end, first, last in ((-np.inf, 2.0, 0.0, 2.0), (398.0, np.inf, 398.0, 399.99)):
        assert read_rig(sqlite_bag, Selection(begin=begin, end=end))[0].time[[0, -1]].tolist() == [first, last]
    window = Bag(sqlite_bag, window=(1000.0, 1001.0))
    assert window.scene() == "a: "
    assert window.message_count == SECONDS * RATE + 1
    assert len(list(window.messages((RIG_STATE,)))) < 0.02 * SECONDS * RATE


@pytest.mark.parametrize(
    "change",
    [
        "DELETE FROM metadata",
        "UPDATE metadata SET metadata = replace(metadata, 'message_count: 1', 'message_count: 7')",
        "DROP INDEX timestamp_idx",
        "INSERT INTO messages(topic_id, timestamp, data) SELECT topic_id, timestamp + 1, data FROM messages LIMIT 1",
    ],
    ids=["killed", "wrong counts", "no index", "two runs"],
)
def test_an_sqlite_bag_without_metadata_or_index_gives_the_same_samples(sqlite_bag, tmp_path, change):
    file = tmp_path / "changed.db3"
    file.write_bytes(next(sqlite_bag.glob("*.db3")).read_bytes())
    with sqlite3.connect(file) as database:
        assert database.execute(change).rowcount
    found = Bag(file, window=(300.0, 310.0))
    assert found.topics[RIG_STATE].count == SECONDS * RATE
    assert len(read_rig(file, Selection(begin=300.0, end=310.0))[0]) == 10 * RATE + 1
    assert found.scene() == "a: "
