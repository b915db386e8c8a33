# SPDX-License-Identifier: Apache-2.0
"""Bag in memory: a run records its messages here, and all that reads bags reads them from here."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from dataclasses import replace
from pathlib import Path

from drill_twin.io.bag.metadata import RecordedTopic, contract_topic
from drill_twin.io.bag.reader import Bag
from drill_twin.io.bag.writer import BagWriter


class MemoryBag(Bag):
    """Messages of a run in memory, with the writing interface of `BagWriter` and the reading interface of `Bag`.

    Attributes:
        start: Time of the first message [ns].
        end: Time of the last message [ns].
    """

    def __init__(self, name: str = "memory") -> None:
        """Begin an empty bag.

        Args:
            name: Name in messages to the user, in place of a path.
        """
        self.path = Path(name)
        self.damage: list[str] = []
        self.topics: dict[str, RecordedTopic] = {}
        self.start = self.end = 0
        self._messages: list[tuple[str, int, bytes]] = []

    def write(self, topic: str, stamp: int, raw: bytes) -> None:
        """Record one message.

        Args:
            topic: Topic of the contract.
            stamp: Time of the recording [ns].
            raw: The message in CDR.
        """
        if topic not in self.topics:
            self.topics[topic] = contract_topic(topic)
        self.topics[topic].count += 1
        if not self._messages:
            self.start = stamp
        self.end = max(self.end, stamp)
        self._messages.append((topic, stamp, bytes(raw)))

    def write_all(self, messages: Iterable[tuple[str, int, bytes]]) -> None:
        """Record messages, each as `write`."""
        for message in messages:
            self.write(*message)

    def messages(self, topics: Collection[str] | None = None) -> Iterator[tuple[str, int, bytes]]:
        """As `Bag.messages`."""
        yield from (message for message in self._messages if topics is None or message[0] in topics)

    def snapshot(self) -> MemoryBag:
        """Copy that later writes do not change; the bytes of the messages are shared."""
        copy = MemoryBag(str(self.path))
        copy.start, copy.end = self.start, self.end
        copy.topics = {name: replace(topic) for name, topic in self.topics.items()}
        copy._messages = self._messages[:]
        return copy


def copy_bag(bag: Bag, folder: str | Path) -> Path:
    """Write all messages of a bag to a new bag folder.

    Returns:
        The folder.

    Raises:
        BagError: The folder exists or cannot be written, or the bag cannot be read.
    """
    with BagWriter(folder, topics=[replace(topic, count=0) for topic in bag.topics.values()]) as writer:
        for topic, stamp, raw in bag.messages():
            writer.write(topic, stamp, raw)
    return writer.folder
