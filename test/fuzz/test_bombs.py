# SPDX-License-Identifier: Apache-2.0
"""Small files that ask for much: refused, or read without their bombs, within 10 s and 500 MB."""

import json
import sqlite3
import struct
import sys
import zlib
from io import BytesIO
from pathlib import Path

import lz4.frame
import numpy as np
import pytest
import zstandard
from companion_parts import part
from mcap.writer import MCAP0_MAGIC
from variants import long_one_of

sys.path.insert(0, str(Path(__file__).parent))

from limited import harmless
from summaries import summarise

from drill_twin.dynamics.twin.checkpoint import Checkpoint
from drill_twin.io.bag.writer import BagWriter
from drill_twin.io.messages.diagnostics import Level, Status, encode_diagnostics
from drill_twin.io.messages.encode import encode_string
from drill_twin.io.messages.topics import DIAGNOSTICS, TWIN_SCENE
from drill_twin.report.recording import read_recording
from drill_twin.runs import Session
from drill_twin.scene import load_scene
from drill_twin.scene.set_points.tables import read_table

PAGE, PLAYER = (part(f"drill_twin_dashboard.live.{name}") for name in ("page_state", "player"))

LAUGHS = "".join(f"k{n}: &a{n} [{', '.join([f'*a{n - 1}' if n else 'x'] * 9)}]\n" for n in range(9))
MERGES = "a0: &a0 {x: 1}\n" + "".join(f"a{n}: &a{n} {{{', '.join([f'<<: *a{n - 1}'] * 9)}}}\n" for n in range(1, 12))
TEXTS = {
    "merge keys": MERGES,
    "a billion laughs": LAUGHS,
    "an alias of itself": "a: &a [*a]\n",
    "20 MB": "".join(f"k{n}: [1, 2, 3]\n" for n in range(1_100_000)),
    "5,000 digits": f"name: {'1' * 5000}\nrun: {{seed: {'9' * 5000}, elements: 0x{'f' * 290}}}\n",
    "nested lists": "a: " + "[" * 50_000,
    "nested blocks": "".join(" " * n + "a:\n" for n in range(1200)),
    "a day that is none": "name: 2024-99-99\nrun: {started: 2024-99-99}\n",
    "70,000 keys": "".join(f"k{n}: 1\n" for n in range(70_000)),
    "4,900 effects": "effects:\n" + "".join(f"  key_{n}: on\n" for n in range(4900)),
    "90,000 sections": "string:\n  sections:\n" + "    - x\n" * 90_000,
    "20,000 marks": "string:\n  marks:\n" + "    - {name: a, distance_from_bit: 1 m}\n" * 20_000,
    "30,000 stations": "hole:\n  survey:\n" + "    - {depth: 1 m}\n" * 30_000,
    "a key of 900,000 characters": "k" * 900_000 + ": 1\n",
    "900,000 digits": "name: " + "1" * 900_000,
    "keys of keys": "{" + "? " * 100_000,
    "a base of itself": "base: scene.yaml\n",
    "a unit of 900,000 characters": "rig: {duration: 1 " + "m" * 900_000 + "}\n",
    "a sum of 100,000 units": "rig: {duration: 1 " + "m*" * 100_000 + "s}\n",
    "a quantity of 900,000 digits": "rig: {duration: " + "1" * 900_000 + " s}\n",
}


def read_bag(path):
    """As `drill-twin analyze` and `watch` do."""
    recording = read_recording(path)
    json.dumps(summarise(recording), allow_nan=False)
    if PLAYER:
        PLAYER.Player(path).close()


@pytest.fixture(scope="module")
def rows(tmp_path_factory):
    """Messages of a short run: topic, stamp [ns], CDR."""
    from drill_twin.io.bag.reader import Bag

    scene = load_scene("pa6_bench", overrides={"duration": "0.1", "numerics.elements": "8"})
    return list(Bag(Session(scene).run(tmp_path_factory.mktemp("run") / "bag_0").bag).messages())


@pytest.fixture
def bag_of(tmp_path, rows):
    def make(more=(), name="bag_0"):
        with BagWriter(tmp_path / name) as writer:
            for row in (*rows, *more):
                writer.write(*row)
        return writer.folder

    return make


@pytest.mark.parametrize("text", TEXTS.values(), ids=TEXTS)
def test_scene_files(text, tmp_path):
    file = tmp_path / "scene.yaml"
    file.write_text(text, "utf-8")
    assert harmless(load_scene, file)


@pytest.mark.parametrize("name", long_one_of(3, TEXTS, short=1))
def test_scene_texts_and_metadata_of_a_bag(name, bag_of, rows):
    text = TEXTS[name]
    folder = bag_of([(TWIN_SCENE, rows[-1][1], encode_string(text))])
    (folder / "metadata.yaml").write_text(text, "utf-8")
    assert not harmless(read_bag, folder)


def test_numbers_of_thousands_of_digits_in_diagnostics(bag_of, rows):
    """In every value that the simulator reports."""
    from drill_twin.io.messages.diagnostics import decode_diagnostics

    keys = {
        key
        for topic, _, raw in rows
        if topic == DIAGNOSTICS
        for status in decode_diagnostics(raw)[1]
        for key in status.values
    }
    values = [
        dict.fromkeys(keys, text) for text in ("9" * 5000, "1e5000", "nan", "-" + "1" * 400, "x" * 1_000_000, "²")
    ]
    factors = ("1", "9" * 5000)
    said = [Status("simulator", Level.OK, "", {**one, "realtime_factor": text}) for one in values for text in factors]
    begun = rows[-1][1]
    folder = bag_of([(DIAGNOSTICS, begun + k, encode_diagnostics(begun + k, [one])) for k, one in enumerate(said)])
    assert not harmless(read_bag, folder)


def zeros(kind, size, *, announced=True):
    """A frame of zeros, made without taking their memory."""
    target, block = BytesIO(), bytes(1 << 20)
    if kind == "zstd":
        stream = zstandard.ZstdCompressor(level=3).stream_writer(target, size=size if announced else -1, closefd=False)
    else:
        stream = lz4.frame.LZ4FrameFile(target, "wb", source_size=size if announced else 0)
    with stream:
        for _ in range(size >> 20):
            stream.write(block)
    return target.getvalue()


def chunk(kind, content, size):
    """Record of a chunk that says that its content has a size."""
    body = struct.pack("<QQQII", 0, 0, size, 0, len(kind)) + kind.encode() + struct.pack("<Q", len(content)) + content
    return struct.pack("<BQ", 6, len(body)) + body


def with_chunks(folder, *chunks):
    """Put chunks behind the header of the file of a bag."""
    file = next(folder.glob("*.mcap"))
    data = file.read_bytes()
    header = len(MCAP0_MAGIC) + 9 + struct.unpack_from("<Q", data, len(MCAP0_MAGIC) + 1)[0]
    file.write_bytes(data[:header] + b"".join(chunks) + data[header:])
    return folder


GIGABYTES = 4 << 30
SMALL = 1 << 20


@pytest.mark.parametrize("kind", ["zstd", "lz4"])
@pytest.mark.parametrize(
    ("announced", "said"),
    [
        (True, GIGABYTES),
        pytest.param(True, SMALL, marks=pytest.mark.nightly),
        pytest.param(False, GIGABYTES, marks=pytest.mark.long),
        (False, SMALL),
        pytest.param(False, 50 << 20, marks=pytest.mark.nightly),
        pytest.param(False, 2**63, marks=pytest.mark.long),
    ],
)
def test_chunks_of_zeros(kind, announced, said, bag_of, bombs):
    folder = with_chunks(bag_of(), chunk(kind, bombs(kind, announced), said))
    assert not harmless(read_bag, folder)


@pytest.fixture(scope="module")
def bombs():
    made = {}

    def make(kind, announced):
        if (kind, announced) not in made:
            made[kind, announced] = zeros(kind, GIGABYTES if kind == "zstd" else 1 << 30, announced=announced)
        return made[kind, announced]

    return make


@pytest.mark.long
def test_many_chunks_that_keep_the_bounds_each(bag_of):
    size = 100 << 20
    one = chunk("zstd", zeros("zstd", size), size)
    assert not harmless(read_bag, with_chunks(bag_of(), *[one] * 200))


RECORDS = {"unknown": struct.pack("<BQ", 200, 0), "messages": struct.pack("<BQHIQQ", 5, 22, 99, 0, 0, 0)}


@pytest.mark.parametrize("record", RECORDS.values(), ids=RECORDS)
def test_many_records_in_a_chunk(record, bag_of):
    content = record * (60_000_000 // len(record))
    packed = zstandard.ZstdCompressor().compress(content)
    refused = harmless(read_bag, with_chunks(bag_of(), chunk("zstd", packed, len(content))))
    assert "expands to more than any recording" in refused


def strings(*parts):
    return b"".join(struct.pack("<I", len(part)) + part for part in parts)


def test_profiles_of_a_channel(bag_of):
    """The metadata of a channel holds YAML too."""
    schema = struct.pack("<H", 99) + strings(b"std_msgs/msg/String", b"ros2msg", b"")
    pairs = strings(b"offered_qos_profiles", (MERGES + "- 1\n" * 10_000).encode())
    channel = struct.pack("<HH", 99, 99) + strings(b"/bomb", b"cdr", pairs)
    records = struct.pack("<BQ", 3, len(schema)) + schema + struct.pack("<BQ", 4, len(channel)) + channel
    assert not harmless(read_bag, with_chunks(bag_of(), records))


@pytest.mark.long
def test_a_file_that_rosbag2_compressed(bag_of, tmp_path):
    """An honest one is read; one of zeros is refused; a bag of honest and hostile messages too."""
    folder = bag_of()
    file = next(folder.glob("*.mcap"))
    packed = file.with_name(file.name + ".zstd")
    packed.write_bytes(zstandard.ZstdCompressor().compress(file.read_bytes()))
    file.unlink()
    assert not harmless(read_bag, folder)
    packed.write_bytes(zeros("zstd", GIGABYTES, announced=False))
    assert "expected a file compressed by rosbag2" in harmless(read_bag, folder)


@pytest.mark.long
def test_messages_that_rosbag2_compressed(bag_of, rows):
    """With `compression_mode: message` each message is a frame, here of 4 GB for some."""
    pack = zstandard.ZstdCompressor().compress
    folder = bag_of(name="other_0")
    for file in folder.iterdir():
        file.unlink()
    folder.rmdir()
    bomb = zeros("zstd", GIGABYTES, announced=False)
    with BagWriter(folder) as writer:
        for topic, stamp, raw in rows:
            writer.write(topic, stamp, pack(raw))
        writer.write(DIAGNOSTICS, rows[-1][1], bomb)
    metadata = folder / "metadata.yaml"
    text = metadata.read_text("utf-8").replace("compression_mode: ''", "compression_mode: MESSAGE")
    metadata.write_text(text.replace("compression_format: ''", "compression_format: zstd"), "utf-8")
    assert not harmless(read_bag, folder)


ENDLESS = "WITH RECURSIVE c(x) AS (SELECT 1 UNION ALL SELECT x+1 FROM c) SELECT x AS id, 1 AS topic_id, x AS timestamp"
CHANGES = {
    "endless view": f"DROP TABLE messages; CREATE VIEW messages AS {ENDLESS}, zeroblob(100) AS data FROM c",
    "computed column": "ALTER TABLE messages ADD COLUMN more AS (zeroblob(100000000))",
    "merge keys": f"UPDATE topics SET offered_qos_profiles = '{MERGES}'",  # noqa: S608
    "a large message": "UPDATE messages SET data = zeroblob(100000000) WHERE id = 1",
}


@pytest.mark.long
@pytest.mark.parametrize("change", CHANGES.values(), ids=CHANGES)
def test_databases(change, rows, tmp_path):
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    from drill_twin.io.messages.topics import TOPICS

    store = get_typestore(Stores.ROS2_JAZZY)
    with Writer(tmp_path / "sql_0", version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
        connections = {
            name: writer.add_connection(name, TOPICS[name].type_name, typestore=store)
            for name in {row[0] for row in rows}
        }
        for name, stamp, raw in rows:
            writer.write(connections[name], stamp, raw)
    assert not harmless(read_bag, tmp_path / "sql_0")
    base = sqlite3.connect(next((tmp_path / "sql_0").glob("*.db3")))
    base.executescript(change)
    base.commit()
    base.close()
    harmless(read_bag, tmp_path / "sql_0")


@pytest.mark.parametrize(
    "entries", [1, pytest.param(200, marks=pytest.mark.long), pytest.param(20_000, marks=pytest.mark.long)]
)
def test_checkpoints(entries, tmp_path):
    """Arrays of zeros, compressed a thousand times; and a header that is no honest JSON."""
    import zipfile

    file = tmp_path / "run.npz"
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        header = BytesIO()
        np.lib.format.write_array(header, np.frombuffer(b'{"format": ' + b"1" * 5000 + b"}", np.uint8))
        archive.writestr("head.npy", header.getvalue())
        block = BytesIO()
        np.lib.format.write_array(block, np.zeros(100_000_000 // (8 * entries)))
        for k in range(entries):
            archive.writestr(f"a{k}.npy", block.getvalue())
    assert harmless(Checkpoint.load, file)


@pytest.mark.parametrize("place", ["/dev/zero", "pipe", "loop", "."])
@pytest.mark.parametrize("read", [load_scene, read_bag, Checkpoint.load, read_table])
def test_what_is_no_file(read, place, tmp_path, monkeypatch):
    import os

    monkeypatch.chdir(tmp_path)
    os.mkfifo("pipe")
    Path("loop").symlink_to("loop")
    assert harmless(read, Path(place))


TABLES = {
    "many columns": b",".join(b"c%d" % k for k in range(400_000)) + b"\n",
    "columns of one name": b"t," * 5_000 + b"\n",
    "a long cell": b"time (s),WOB (N)\n0," + b"1" * 1_000_000 + b"\n",
    "a long header": b"time" + b"x" * 1_000_000 + b",WOB (N),rpm\n0,1,2\n1,2,3\n",
    "quotes": b'"' * 1_000_000,
    "UTF-16": "time (s),WOB (N)\n0,1\n".encode("utf-16"),
    "UTF-32": "time (s),WOB (N)\n0,1\n".encode("utf-32"),
    "Latin-1": "Zeit (s),Gewicht über alles (N)\n0,1\n".encode("latin-1"),
    "separators of lines": "time (s),WOB (N)\u2028,rpm\x0b\x1c\n0,1,2\n".encode(),
    "nothing but commas": b"," * 1_000_000,
    "empty lines": b"\n" * 5_000_000,
    "no numbers": b"time (s),WOB (N),rpm\n" + b"nan,nan,nan\n" * 1000,
    "infinite": b"time (s),WOB (N),rpm\n" + b"".join(b"%d,inf,1e400\n" % k for k in range(1000)),
}


@pytest.mark.parametrize("content", TABLES.values(), ids=TABLES)
def test_tables(content, tmp_path):
    file = tmp_path / "table.csv"
    file.write_bytes(content)
    assert harmless(read_table, file)


@pytest.mark.long
def test_a_matlab_file_of_zeros(tmp_path):
    """An array that says that it has 16 GB, with 1 GB of zeros in 1 to 5 MB, compressed as MATLAB does."""
    name = b"time"
    head = struct.pack("<IIII", 6, 8, 6, 0) + struct.pack("<IIii", 5, 8, 2**31 - 1, 1)
    head += struct.pack("<HH4s", 1, 4, name) + struct.pack("<II", 9, 2**32 - 8)
    target = BytesIO()
    packer = zlib.compressobj(1)
    target.write(packer.compress(struct.pack("<II", 14, 2**32 - 8) + head))
    block = bytes(16 << 20)
    for _ in range((1 << 30) // len(block)):
        target.write(packer.compress(block))
    target.write(packer.flush())
    body = target.getvalue()
    file = tmp_path / "table.mat"
    start = b"MATLAB 5.0 MAT-file" + b" " * 105 + b"\x00\x01IM"
    file.write_bytes(start + struct.pack("<II", 15, len(body)) + body)
    assert harmless(read_table, file)


def test_topics_of_the_page_are_those_attacked():
    assert {TWIN_SCENE, DIAGNOSTICS} < set(PAGE.INPUTS)
