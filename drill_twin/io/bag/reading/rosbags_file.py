# SPDX-License-Identifier: Apache-2.0
"""SQLite file of a rosbag2 bag, read by rosbags."""

from __future__ import annotations

import sqlite3
from collections.abc import Collection, Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

from rosbags.rosbag2 import Reader
from rosbags.rosbag2.metadata import dump_qos_v9

from drill_twin.errors import BagError
from drill_twin.io.bag.metadata import RecordedTopic
from drill_twin.io.bag.reading.decompression import decompressed_message
from drill_twin.io.bag.reading.qos import refuse_large

_TABLES = ("topics", "messages", "schema", "metadata", "message_definitions")
_LARGEST_DEFINITION = 4000  # characters of the SQL that made a table


class RosbagsFile:
    """Single `.db3` file; as `McapFile`."""

    def __init__(self, path: Path, *, name: Path | None = None, compressed_messages: bool = False) -> None:
        """Open a file.

        Args:
            path: The file.
            name: Its name in messages, if it was decompressed from another.
            compressed_messages: True if rosbag2 compressed each message.

        Raises:
            BagError: It is no such file, or a damaged one.
        """
        self.path, self._name, self._compressed = path, name or path, compressed_messages
        self.temporary: object = None
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
                yield connection.topic, stamp, decompressed_message(raw) if self._compressed else bytes(raw)

    @contextmanager
    def _opened(self) -> Iterator[Reader]:
        try:
            _refuse_computed_tables(self.path)
            with Reader(self.path) as reader:
                yield reader
        except Exception as error:  # of rosbags, YAML or SQLite
            raise BagError(f"{self._name}: expected a rosbag2 bag, found {_one_line(error)}") from error


def _refuse_computed_tables(path: Path) -> None:
    """Refuse a database whose tables are views or have computed columns: reading them may take any time.

    Raises:
        ValueError, sqlite3.Error: It is such a one, or no database.
    """
    with closing(sqlite3.connect(f"{path.absolute().as_uri()}?mode=ro&immutable=1", uri=True)) as connection:
        marks = ", ".join("?" * len(_TABLES))
        rows = connection.execute(
            f"SELECT name, type, substr(sql, 1, ?) FROM sqlite_master WHERE lower(name) IN ({marks})",  # noqa: S608
            (_LARGEST_DEFINITION, *_TABLES),
        ).fetchmany(len(_TABLES))
        for name, kind, text in rows:
            if kind != "table" or " as " in f" {' '.join(str(text).lower().replace('(', ' ( ').split())} ":
                raise ValueError(f"`{name}` is no plain table")
        if {name.lower() for name, *_ in rows} >= {"topics"}:
            columns = [column[1] for column in connection.execute("PRAGMA table_info(topics)")]
            if "offered_qos_profiles" in columns:
                for (text,) in connection.execute("SELECT offered_qos_profiles FROM topics LIMIT 10000"):
                    refuse_large(str(text))


def _recorded(connection: Any) -> RecordedTopic:
    return RecordedTopic(
        connection.topic,
        connection.msgtype,
        connection.msgdef.data,
        connection.digest,
        [dict(profile) for profile in dump_qos_v9(connection.ext.offered_qos_profiles)],
    )


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split())[:300] or type(error).__name__
