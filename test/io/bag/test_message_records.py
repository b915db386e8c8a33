# SPDX-License-Identifier: Apache-2.0
"""Messages packed in one piece give the bytes of mcap's own writer."""

from io import BytesIO

import pytest
from mcap.writer import CompressionType, Writer

from drill_twin.io.bag.writing import message_records
from drill_twin.io.bag.writing.message_records import message_appender

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


@pytest.mark.parametrize("known", [True, False], ids=["mcap as known", "another mcap"])
def test_the_bytes_are_those_of_the_library(monkeypatch, known):
    if not known:
        monkeypatch.setattr(message_records, "_PRIVATE", ("_Writer__no_such_name",))
    assert _file(message_appender) == _file(_slow)
