# SPDX-License-Identifier: Apache-2.0
"""Reader of bags with other storage (sqlite3, compressed files or messages), through rosbags."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from rosbags.rosbag2 import Reader
from rosbags.rosbag2.metadata import dump_qos_v9

from drill_twin.errors import BagError
from drill_twin.io.bag.metadata import RecordedTopic


class RosbagsFile:
    """Bag folder with `metadata.yaml`, or a single storage file; as `McapFile`."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.topics: dict[str, RecordedTopic] = {}
        self.start: int | None = None
        self.end: int | None = None
        self.damage: list[str] = []
        with self._opened() as reader:
            for connection in reader.connections:
                recorded = self.topics.setdefault(connection.topic, _recorded(connection))
                recorded.count += connection.msgcount
            if reader.message_count:
                self.start, self.end = reader.start_time, reader.end_time - 1

    def messages(self, topics: Collection[str] | None = None) -> Iterator[tuple[str, int, bytes]]:
        """Topic, time of recording [ns] and CDR of each message, in order of time."""
        with self._opened() as reader:
            wanted = [c for c in reader.connections if topics is None or c.topic in topics]
            if not wanted:  # rosbags reads all topics where none is selected
                return
            for connection, stamp, raw in reader.messages(wanted):
                yield connection.topic, stamp, bytes(raw)

    @contextmanager
    def _opened(self) -> Iterator[Reader]:
        try:
            with Reader(self.path) as reader:
                yield reader
        except Exception as error:  # of rosbags, YAML or SQLite
            raise BagError(f"{self.path}: expected a rosbag2 bag, found {_one_line(error)}") from error


def _recorded(connection: Any) -> RecordedTopic:
    return RecordedTopic(
        connection.topic,
        connection.msgtype,
        connection.msgdef.data,
        connection.digest,
        [dict(profile) for profile in dump_qos_v9(connection.ext.offered_qos_profiles)],
    )


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split()) or type(error).__name__
