# SPDX-License-Identifier: Apache-2.0
"""Messages packed in one piece give the bytes of mcap's own writer."""

from io import BytesIO
from pathlib import Path

import mcap
from mcap.writer import CompressionType, Writer

from drill_twin.io.bag.file_writer import message_appender

ROOT = Path(__file__).parents[3]
MESSAGES = [(1 + k % 3, (k * 7919) % 5000 + 100, bytes([k % 256]) * (k % 211), k) for k in range(3000)]


def _file(appender):
    stream = BytesIO()
    writer = Writer(stream, chunk_size=20_000, compression=CompressionType.ZSTD)
    writer.start(profile="ros2", library="test")
    schema = writer.register_schema("std_msgs/msg/String", "ros2msg", b"string data")
    for name in "abc":
        writer.register_channel(name, "cdr", schema)
    append = appender(writer)
    for k, message in enumerate(MESSAGES):
        append([message])
        if k % 700 == 650:
            writer.flush()
    writer.finish()
    return stream.getvalue()


def _slow(writer):
    return lambda messages: [writer.add_message(channel, at, raw, at, k) for channel, at, raw, k in messages]


def test_the_bytes_are_those_of_the_library():
    assert _file(message_appender) == _file(_slow)


def test_another_mcap_than_the_one_that_is_known_is_noticed():
    """`setup.py` allows the versions whose private names are used; another one has others, or none."""
    (allowed,) = (line for line in (ROOT / "setup.py").read_text("utf-8").splitlines() if '"mcap>=' in line)
    assert '"mcap>=1.6,<1.7"' in allowed
    assert mcap.__version__.startswith("1.6.")
    used = {"chunk_builder", "statistics", "maybe_finalize_chunk", "chunk_size", "chunk_indices"}
    assert all(hasattr(Writer(BytesIO()), f"_Writer__{name}") for name in used)
