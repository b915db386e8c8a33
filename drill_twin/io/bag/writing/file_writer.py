# SPDX-License-Identifier: Apache-2.0
"""Writer of one MCAP file of a bag."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, cast

from mcap.writer import CompressionType, Writer

from drill_twin import __version__
from drill_twin.errors import BagError
from drill_twin.io.bag.metadata import RecordedTopic, to_yaml
from drill_twin.io.bag.writing.checked_stream import CheckedStream
from drill_twin.io.bag.writing.chunk_indices import pack_indices
from drill_twin.io.bag.writing.message_records import message_appender

_CHUNK_SIZE = 256 * 1024


class FileWriter:
    """Open MCAP file; an error of the disk closes it.

    Attributes:
        path: The file.
        start: Earliest time of recording [ns]; None before the first message.
        end: Latest time of recording [ns].
        count: Messages so far.

    Raises:
        OSError: Raised by the constructor if the file cannot be created.
        BagError: Raised by the methods if it cannot be written.
    """

    def __init__(self, path: Path, topics: Iterable[RecordedTopic]) -> None:
        self.path = path
        self.start: int | None = None
        self.end = 0
        self.count = 0
        self._stream = CheckedStream(path)
        self._writer = Writer(cast("Any", self._stream), chunk_size=_CHUNK_SIZE, compression=CompressionType.ZSTD)
        pack_indices(self._writer)
        self._append = message_appender(self._writer)
        self._writer.start(profile="ros2", library=f"drill_twin {__version__}")
        self._channels: dict[str, int] = {}
        self._schemas: dict[str, int] = {}
        for topic in topics:
            self.add_topic(topic)

    @property
    def size(self) -> int:
        """Size of the file [bytes], without the chunk that is still open."""
        return self._stream.tell()

    def add_topic(self, topic: RecordedTopic) -> None:
        """Register a topic before its first message."""
        if topic.type_name not in self._schemas:
            self._schemas[topic.type_name] = self._writer.register_schema(
                topic.type_name, "ros2msg", topic.definition.encode()
            )
        self._channels[topic.name] = self._writer.register_channel(
            topic.name,
            "cdr",
            self._schemas[topic.type_name],
            {"offered_qos_profiles": to_yaml(list(topic.qos)).strip(), "topic_type_hash": topic.type_hash},
        )

    def write(self, messages: Sequence[tuple[str, int, bytes, int]]) -> None:
        """Append messages: topic, time of recording [ns], bytes and number on the topic of each."""
        stamps = [stamp for _, stamp, _, _ in messages]
        self.start = min(stamps) if self.start is None else min(self.start, *stamps)
        self.end = max(self.end, *stamps)
        self.count += len(messages)
        channels = self._channels
        try:
            self._append((channels[topic], stamp, raw, number) for topic, stamp, raw, number in messages)
        except OSError as error:
            raise self.broken(error) from error

    def flush(self) -> None:
        """Close the open chunk and pass it to the operating system."""
        try:
            self._writer.flush()  # type: ignore[no-untyped-call]
            self._stream.flush()
        except OSError as error:
            raise self.broken(error) from error

    def change(self) -> str:
        """Another program's change of the file since its last flush, in words; empty if there is none."""
        return self._stream.change()

    def abandon(self) -> None:
        """Close the file as it is; it can be read as far as it goes."""
        with suppress(OSError):
            self._stream.close()

    def finish(self, information: Mapping[str, Any]) -> None:
        """Close the file; `information` is rosbag2's metadata of the bag."""
        try:
            self._writer.flush()  # type: ignore[no-untyped-call]
            self._writer.add_metadata("rosbag2", {"serialized_metadata": to_yaml(information).strip()})
            self._writer.finish()  # type: ignore[no-untyped-call]
            self._stream.close()
        except OSError as error:
            raise self.broken(error) from error

    def broken(self, error: OSError) -> BagError:
        """Close the file after an error of the disk, and return the error to raise."""
        with suppress(OSError):  # fails for the same reason
            self._stream.close()
        return BagError(
            f"{self.path}: expected to go on writing the bag, found {error.strerror or error}; "
            "make room there or choose another folder; what was written so far can be read"
        )
