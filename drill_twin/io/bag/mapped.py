# SPDX-License-Identifier: Apache-2.0
"""Bags of other people: their topics under our names."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from pathlib import Path

from drill_twin.errors import BagError
from drill_twin.io.bag.metadata import Recorded
from drill_twin.io.bag.reader import Bag


def names_from(pairs: Iterable[str], what: str) -> dict[str, str]:
    """Our names by theirs, from texts such as "/camera/marks=/marks/state".

    Args:
        pairs: The texts.
        what: Where they were given, for the error.

    Raises:
        BagError: One is no such pair.
    """
    names = {}
    for pair in pairs:
        theirs, equals, ours = (part.strip() for part in pair.partition("="))
        if not (equals and theirs and ours):
            raise BagError(f'{what}: expected THEIRS=OURS such as "/camera/marks=/marks/state", found "{pair}"')
        names[theirs] = ours
    return names


class MappedBag(Bag):
    """A bag whose topics have other names than ours."""

    def __init__(self, path: str | Path, topics: Mapping[str, str]) -> None:
        """Opens a bag; `topics` says what a topic of the bag is called here.

        Raises:
            BagError: As `Bag`; or the bag has no such topic, or already one of the name it would get.
        """
        self._ours = dict(topics)
        super().__init__(path)

    def _check_topics(self) -> None:
        self.topics = renamed(self.topics, self._ours, str(self.path))
        super()._check_topics()

    def messages(self, topics: Collection[str] | None = None) -> Iterator[tuple[str, int, bytes]]:
        """As `Bag.messages`, under our names."""
        theirs = {ours: name for name, ours in self._ours.items()}
        wanted = None if topics is None else [theirs.get(topic, topic) for topic in topics]
        for name, stamp, raw in super().messages(wanted):
            yield self._ours.get(name, name), stamp, raw


def renamed(found: Mapping[str, Recorded], ours: Mapping[str, str], where: str) -> dict[str, Recorded]:
    """The topics of a bag under our names.

    Raises:
        BagError: The bag has no such topic, or already one of the name it would get.
    """
    for name, wanted in ours.items():
        if name not in found:
            raise BagError(f"{where}: expected the topic {name} to read as {wanted}, found {', '.join(sorted(found))}")
        if wanted in found and found[wanted].count and wanted not in ours:
            raise BagError(f"{where}: expected no topic {wanted} beside {name} that is to be read as it, found one")
    kept = {name: topic for name, topic in found.items() if name not in ours and name not in ours.values()}
    return kept | {wanted: found[name] for name, wanted in ours.items()}
