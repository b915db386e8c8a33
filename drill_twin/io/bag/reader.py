# SPDX-License-Identifier: Apache-2.0
"""Reader of bags, complete or left by a killed writer."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from pathlib import Path

from drill_twin.errors import BagError
from drill_twin.io.bag.files import BagFile, open_files
from drill_twin.io.bag.metadata import RecordedTopic
from drill_twin.io.messages.decode import read_string
from drill_twin.io.messages.topics import GENERIC, TOPICS, TWIN_SCENE


class Bag:
    """Bag with topics of the contract; it can be read any number of times.

    Attributes:
        path: Bag folder or file.
        topics: Topics by name.
        start: Earliest time of recording [ns].
        end: Latest time of recording [ns].
        damage: Sentences on missing or damaged parts; the rest of the bag can be read.
    """

    def __init__(self, path: str | Path) -> None:
        """Open a bag folder or a single file.

        Args:
            path: Bag folder, `.mcap` or `.db3` file.

        Raises:
            BagError: Nothing is there, it is not a bag, it has no messages, or none on a topic of the contract.
        """
        self.path = Path(path)
        self._files, empty_files = open_files(self.path)
        self.damage: list[str] = [*(text for file in self._files for text in file.damage), *empty_files]
        self.topics: dict[str, RecordedTopic] = _merged(self._files)
        starts = [file.start for file in self._files if file.start is not None]
        ends = [file.end for file in self._files if file.end is not None]
        if not starts:
            raise BagError(f"{self.path}: expected a bag with messages, found none{self._because()}; record it again")
        self.start: int = min(starts)
        self.end: int = max(ends)
        self._check_topics()

    @property
    def truncated(self) -> bool:
        """True if the writer did not finish the bag, or a part of it is damaged."""
        return bool(self.damage)

    @property
    def message_count(self) -> int:
        """Number of messages on all topics."""
        return sum(topic.count for topic in self.topics.values())

    def messages(self, topics: Collection[str] | None = None) -> Iterator[tuple[str, int, bytes]]:
        """Topic, time of recording [ns] and CDR of each message, in recorded order.

        Args:
            topics: Names of topics to read; by default all.
        """
        held = (name for file in self._files for name in file.topics)
        wanted = frozenset(held if topics is None else topics) - self._other_type
        for file in self._files:
            yield from file.messages(wanted)

    def last(self, topic: str) -> bytes | None:
        """CDR of the last message on a topic; None without messages."""
        raw = None
        for _, _, raw in self.messages((topic,)):  # noqa: B007  only the last value is used
            pass
        return raw

    def scene(self) -> str:
        """Resolved scene of the recorded run, a YAML text with a `run` block.

        Raises:
            BagError: The bag has no scene.
        """
        raw = self.last(TWIN_SCENE)
        if raw is None:
            raise BagError(f"{self.path}: expected the scene on {TWIN_SCENE}, found no message there; name the scene")
        return read_string(raw)

    def _because(self) -> str:
        return f" ({'; '.join(self.damage)})" if self.damage else ""

    def _check_topics(self) -> None:
        others = {
            name: topic
            for name, topic in self.topics.items()
            if name in TOPICS and topic.type_name != TOPICS[name].type_name
        }
        for name, topic in others.items():
            del self.topics[name]
            self.damage.append(
                f"expected {name} as {TOPICS[name].type_name}, found {topic.type_name}: "
                f"its {topic.count} messages are left out"
            )
        self._other_type = frozenset(others)
        if not any(name in TOPICS and name not in GENERIC and topic.count for name, topic in self.topics.items()):
            found = ", ".join(f"{name} ({topic.type_name})" for name, topic in sorted(self.topics.items()))
            raise BagError(
                f"{self.path}: expected topics of drill_twin such as /string/poses "
                f"or /marks/state, found only {found or 'others'}{self._because()}; the bag is of another package"
            )


def _merged(files: Sequence[BagFile]) -> dict[str, RecordedTopic]:
    topics: dict[str, RecordedTopic] = {}
    for file in files:
        for name, topic in file.topics.items():
            if name in topics:
                topics[name].count += topic.count
            else:
                topics[name] = topic
    return topics
