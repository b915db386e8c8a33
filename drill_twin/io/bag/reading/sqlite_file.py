# SPDX-License-Identifier: Apache-2.0
"""SQLite file of a rosbag2 bag. A window of time is found by the file's index of timestamps."""

import sqlite3
from collections.abc import Collection, Generator, Iterator
from contextlib import closing, contextmanager
from typing import Any

from drill_twin.core.errors import BagError
from drill_twin.core.files.yaml_reader import YamlError, plain_yaml
from drill_twin.io.bag.metadata import RecordedTopic
from drill_twin.io.bag.reading.bag_file import LATCHED, MOST_LATCHED, BagFile, blocks_between, qos_profiles
from drill_twin.io.messages.stamps import raw_header_stamp
from drill_twin.io.messages.topic_row import WITH_HEADER
from drill_twin.io.messages.topics import DIAGNOSTICS

_TABLES = ("topics", "messages", "schema", "metadata", "message_definitions")
_LARGEST_DEFINITION = 4000  # characters of the SQL that made a table
_MOST_TOPICS = 10_000
_BLOCKS = 1000  # of equal time of recording, in which a window is searched
_SAMPLES = 16  # messages that tell the stamps of a block
_LAST_DIAGNOSTICS = 20  # of all nodes; the counts at the end of the run are read
_OF_A_KIND = "typeof(timestamp) = 'integer' AND typeof(data) = 'blob'"  # else damaged: SQLite checks no types


class SqliteFile(BagFile):
    """Single `.db3` file."""

    def _open(self, window: tuple[float, float] | None) -> None:
        self._names: dict[int, str] = {}
        self._between: tuple[int, int] | None = None  # times of recording [ns], the second excluded
        with self._opened() as database:
            self._read_topics(database)
            self.start, self.end = database.execute(
                "SELECT (SELECT min(timestamp) FROM messages), (SELECT max(timestamp) FROM messages)"
            ).fetchone()
            if {type(self.start), type(self.end)} - {int, type(None)}:
                raise ValueError("times that are no whole numbers")
            if window is not None and self.start is not None and self._searchable(database):
                self._between = self._find(database, self.start, self.end, *window)

    def messages(self, topics: Collection[str] | None = None) -> Iterator[tuple[str, int, bytes]]:
        """As of `BagFile`, in order of time."""
        wanted = [number for number, name in self._names.items() if topics is None or name in topics]
        with self._opened() as database:
            if self._between is None:
                yield from self._select(database, wanted, "1")
                return
            begin, end = self._between
            apart = self._apart(database, wanted)
            for _, row in (pair for pair in apart if pair[0] < begin):
                yield from self._select(database, wanted, "id = ?", row)
            yield from self._select(database, wanted, "timestamp >= ? AND timestamp < ?", begin, end)
            for _, row in (pair for pair in apart if pair[0] >= end):
                yield from self._select(database, wanted, "id = ?", row)

    @contextmanager
    def _opened(self) -> Iterator[sqlite3.Connection]:
        try:
            address = f"{self.path.absolute().as_uri()}?mode=ro&immutable=1"
            with closing(sqlite3.connect(address, uri=True, check_same_thread=False)) as database:
                _refuse_computed_tables(database)
                yield database
        except Exception as error:  # of SQLite and of values that are of another type than they should be
            raise BagError(f"{self.title}: expected a rosbag2 bag, found {_one_line(error)}") from error

    def _read_topics(self, database: sqlite3.Connection) -> None:
        definitions: dict[str, str] = {}
        if _columns(database, "message_definitions"):
            definitions = dict(
                database.execute(
                    "SELECT topic_type, encoded_message_definition FROM message_definitions ORDER BY id DESC"
                )
            )
        present = _columns(database, "topics")
        optional = [name if name in present else "''" for name in ("offered_qos_profiles", "type_description_hash")]
        rows = database.execute(f"SELECT id, name, type, {', '.join(optional)} FROM topics ORDER BY id")  # noqa: S608
        for number, name, kind, qos, digest in rows.fetchmany(_MOST_TOPICS):
            if not (isinstance(name, str) and isinstance(kind, str)):
                raise TypeError("a topic without a name or a type")
            self._names[number] = name
            recorded = RecordedTopic(name, kind, str(definitions.get(kind, "")), str(digest), qos_profiles(str(qos)))
            self.topics.setdefault(name, recorded)
        for number, count in _counts(database, self._names).items():
            if number in self._names:
                self.topics[self._names[number]].count += count

    def _select(
        self, database: sqlite3.Connection, topics: Collection[int], condition: str, *values: int
    ) -> Generator[tuple[str, int, bytes]]:
        """Topic, time of recording [ns] and CDR of the messages on topics under a condition, in order of time."""
        marks = ", ".join("?" * len(topics))
        query = (
            f"SELECT topic_id, timestamp, data FROM messages WHERE {condition} AND topic_id IN ({marks}) "  # noqa: S608
            f"AND {_OF_A_KIND} ORDER BY timestamp"
        )
        for number, stamp, raw in database.execute(query, (*values, *topics)):
            yield self._names[number], stamp, self._message(raw)

    def _searchable(self, database: sqlite3.Connection) -> bool:
        """Check that times are indexed, and that the file holds one run: in several, stamps do not rise."""
        indexed = any(
            [column[2] for column in database.execute(f'PRAGMA index_info("{name}")')][:1] == ["timestamp"]
            for _, name, *_ in database.execute("PRAGMA index_list(messages)").fetchall()
            if '"' not in name
        )
        return indexed and not self._has_several_runs()

    def _find(
        self, database: sqlite3.Connection, start: int, end: int, earliest: float, latest: float
    ) -> tuple[int, int]:
        """Times of recording [ns] between which the messages with header stamps between two times [s] were recorded."""
        headed = [number for number, name in self._names.items() if self.topics[name].type_name in WITH_HEADER]
        edges = [start + (end + 1 - start) * k // _BLOCKS for k in range(_BLOCKS + 1)]

        def stamps_at(k: int) -> list[int]:
            with closing(
                self._select(database, headed, "timestamp >= ? AND timestamp < ?", edges[k], edges[k + 1])
            ) as messages:
                return [raw_header_stamp(raw) for (_, _, raw), _ in zip(messages, range(_SAMPLES), strict=False)]

        found = blocks_between(_BLOCKS, earliest, latest, stamps_at)
        return edges[found.start], edges[found.stop]

    def _apart(self, database: sqlite3.Connection, wanted: Collection[int]) -> list[tuple[int, int]]:
        """Times of recording [ns] and numbers of the rows that are read wherever they are, in order of time."""
        rows: list[tuple[int, int]] = []
        for number in wanted:
            name = self._names[number]
            count = self.topics[name].count
            if name.endswith(LATCHED):
                limit, order = min(count, MOST_LATCHED), "id"
            elif name.endswith(DIAGNOSTICS):
                limit, order = min(count, _LAST_DIAGNOSTICS), "timestamp DESC"
            else:
                continue
            query = f"SELECT timestamp, id FROM messages WHERE topic_id = ? AND {_OF_A_KIND} ORDER BY {order} LIMIT ?"  # noqa: S608
            rows += database.execute(query, (number, limit))  # the limit ends the search at the last such row
        return sorted(rows)


def _refuse_computed_tables(database: sqlite3.Connection) -> None:
    """Refuse a database whose tables are views or have computed columns: reading them may take any time.

    Raises:
        ValueError, sqlite3.Error: The database has such tables, or the file is no database.
    """
    marks = ", ".join("?" * len(_TABLES))
    rows = database.execute(
        f"SELECT name, type, substr(sql, 1, ?) FROM sqlite_master WHERE lower(name) IN ({marks})",  # noqa: S608
        (_LARGEST_DEFINITION, *_TABLES),
    ).fetchmany(len(_TABLES))
    for name, kind, text in rows:
        if kind != "table" or " as " in f" {' '.join(str(text).lower().replace('(', ' ( ').split())} ":
            raise ValueError(f"`{name}` is no plain table")


def _columns(database: sqlite3.Connection, table: str) -> set[str]:
    return {row[1] for row in database.execute(f"PRAGMA table_info({table})")}


def _counts(database: sqlite3.Connection, names: dict[int, str]) -> dict[int, int]:
    """Messages by topic: as the recorder noted them where that fits the file, else counted, for which all is read."""
    (total,) = database.execute("SELECT count(*) FROM messages").fetchone()
    noted = _noted_counts(database)
    if noted.keys() == set(names.values()) and len(names) == len(noted) and sum(noted.values()) == total:
        return {number: noted[name] for number, name in names.items()}
    return dict(database.execute("SELECT topic_id, count(*) FROM messages GROUP BY topic_id"))


def _noted_counts(database: sqlite3.Connection) -> dict[str, int]:
    """Messages by topic in the metadata that the recorder wrote as it ended; empty without."""
    if not _columns(database, "metadata"):
        return {}
    row = database.execute("SELECT metadata FROM metadata ORDER BY id DESC LIMIT 1").fetchone()
    try:
        content: Any = plain_yaml(row[0], "metadata") if row else {}
        content = content.get("rosbag2_bagfile_information", content)  # rosbags writes the inner mapping only
        topics = content["topics_with_message_count"]
        return {topic["topic_metadata"]["name"]: int(topic["message_count"]) for topic in topics}
    except (YamlError, AttributeError, KeyError, TypeError, ValueError):
        return {}


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split())[:300] or type(error).__name__
