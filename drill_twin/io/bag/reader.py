# SPDX-License-Identifier: Apache-2.0
"""Reader of bags, complete or left by a killed writer."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from pathlib import Path

from drill_twin.core.errors import BagError
from drill_twin.io.bag.metadata import RecordedTopic
from drill_twin.io.bag.reading.files import BagFile, open_files
from drill_twin.io.bag.topic_names import choose_namespace, is_of_another_twin, recorded_names
from drill_twin.io.messages.decode import read_string
from drill_twin.io.messages.topics import DIAGNOSTICS, GENERIC, TOPICS, TWIN_SCENE


class Bag:
    """Bag with topics of the contract; it can be read any number of times.

    Attributes:
        path: Bag folder or file.
        topics: Topics by name; those of a twin in a namespace have their names without it.
        namespace: Namespace of the twin, as "/rig2"; "" for the root.
        start: Earliest time of recording [ns].
        end: Latest time of recording [ns].
        damage: Sentences on missing or damaged parts; the rest of the bag can be read.
    """

    namespace = ""

    def __init__(
        self,
        path: str | Path,
        *,
        names: Mapping[str, str] | None = None,
        namespace: str | None = None,
        window: tuple[float, float] | None = None,
    ) -> None:
        """Open a bag folder or a single file.

        Args:
            path: Bag folder, `.mcap` or `.db3` file.
            names: Names of the contract by the bag's names, for a bag that has others.
            namespace: Namespace of the twin to read; None: the only one.
            window: Header stamps [s] between which messages are wanted: a complete MCAP file is then read by its index,
                and messages outside may be left out. None: all.

        Raises:
            BagError: Nothing is there, it is not a bag, it has no messages, or none on a topic of the contract; it
                holds several twins and none was chosen; or `names` does not fit it.
        """
        self.path = Path(path)
        self._files, empty_files = open_files(self.path, window)
        self.damage: list[str] = [*(text for file in self._files for text in file.damage), *empty_files]
        self._open_topics(_merged(self._files), names or {}, namespace)
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
        wanted = {self._recorded[name] for name in (self.topics if topics is None else topics) if name in self.topics}
        ours = {recorded: name for name, recorded in self._recorded.items()}
        for file in self._files:
            for recorded, stamp, raw in file.messages(wanted):
                if recorded != DIAGNOSTICS or not is_of_another_twin(raw, self.namespace):
                    yield ours[recorded], stamp, raw

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

    def _open_topics(self, found: Mapping[str, RecordedTopic], names: Mapping[str, str], namespace: str | None) -> None:
        where = str(self.path)
        unnamed = {name: topic for name, topic in found.items() if name not in names}
        self.namespace = choose_namespace(unnamed, namespace, where)
        self._recorded = recorded_names(found, names, self.namespace, where)
        ours = {recorded: name for name, recorded in self._recorded.items()}
        self.topics: dict[str, RecordedTopic] = {ours[name]: topic for name, topic in found.items() if name in ours}

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
