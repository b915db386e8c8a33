# SPDX-License-Identifier: Apache-2.0
"""Read bags that rosbag2 wrote in other ways (sqlite3, compressed files or messages), through rosbags."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from rosbags.rosbag2 import Reader
from rosbags.rosbag2.metadata import dump_qos_v9

from drill_twin.errors import BagError
from drill_twin.io.bag.metadata import Recorded


class RosbagsFile:
    """A bag folder with `metadata.yaml`, or one storage file, read by rosbags."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.topics: dict[str, Recorded] = {}
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
        """Topic, time of recording [ns] and CDR of each message, in the order of their times."""
        with self._opened() as reader:
            wanted = [c for c in reader.connections if topics is None or c.topic in topics]
            if not wanted:  # rosbags takes an empty choice for no choice
                return
            for connection, stamp, raw in reader.messages(wanted):
                yield connection.topic, stamp, bytes(raw)

    @contextmanager
    def _opened(self) -> Iterator[Reader]:
        try:
            with Reader(self.path) as reader:
                yield reader
        except Exception as error:  # rosbags, YAML and two SQLites under it raise classes of their own
            raise BagError(f"{self.path}: expected a rosbag2 bag, found {_one_line(error)}") from error


def _recorded(connection: Any) -> Recorded:
    return Recorded(
        connection.topic,
        connection.msgtype,
        connection.msgdef.data,
        connection.digest,
        [dict(profile) for profile in dump_qos_v9(connection.ext.offered_qos_profiles)],
    )


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split()) or type(error).__name__
