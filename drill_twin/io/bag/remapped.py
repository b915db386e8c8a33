# SPDX-License-Identifier: Apache-2.0
"""Bags whose topics have other names than those of the contract."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from pathlib import Path

from drill_twin.errors import BagError
from drill_twin.io.bag.metadata import RecordedTopic
from drill_twin.io.bag.reader import Bag


def parse_remappings(pairs: Iterable[str], option: str) -> dict[str, str]:
    """Names of the contract by the bag's names, from texts such as "/camera/marks=/marks/state".

    Args:
        pairs: The texts.
        option: Option or parameter that gave them, for the error.

    Raises:
        BagError: A text is not such a pair.
    """
    names = {}
    for pair in pairs:
        theirs, equals, ours = (part.strip() for part in pair.partition("="))
        if not (equals and theirs and ours):
            raise BagError(f'{option}: expected THEIRS=OURS such as "/camera/marks=/marks/state", found "{pair}"')
        names[theirs] = ours
    return names


class RemappedBag(Bag):
    """Bag read under the topic names of the contract."""

    def __init__(self, path: str | Path, topics: Mapping[str, str]) -> None:
        """Open a bag.

        Args:
            path: Bag folder or file.
            topics: Names of the contract by the bag's names.

        Raises:
            BagError: As `Bag`; or the bag has no such topic, or already one of the new name.
        """
        self._remappings = dict(topics)
        super().__init__(path)

    def _check_topics(self) -> None:
        self.topics = remapped(self.topics, self._remappings, str(self.path))
        super()._check_topics()

    def messages(self, topics: Collection[str] | None = None) -> Iterator[tuple[str, int, bytes]]:
        """As `Bag.messages`, under the names of the contract."""
        names = {new: name for name, new in self._remappings.items()}
        wanted = [
            names.get(topic, topic) for topic in (self.topics if topics is None else topics) if topic in self.topics
        ]
        for name, stamp, raw in super().messages(wanted):
            yield self._remappings.get(name, name), stamp, raw


def remapped(found: Mapping[str, RecordedTopic], remappings: Mapping[str, str], where: str) -> dict[str, RecordedTopic]:
    """Topics of a bag under the names of the contract.

    Raises:
        BagError: The bag has no such topic, or already one of the new name.
    """
    for name, wanted in remappings.items():
        if name not in found:
            raise BagError(f"{where}: expected the topic {name} to read as {wanted}, found {', '.join(sorted(found))}")
        if wanted in found and found[wanted].count and wanted not in remappings:
            raise BagError(f"{where}: expected no topic {wanted} beside {name} that is to be read as it, found one")
    kept = {name: topic for name, topic in found.items() if name not in remappings and name not in remappings.values()}
    return kept | {wanted: found[name] for name, wanted in remappings.items()}
