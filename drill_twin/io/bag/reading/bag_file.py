# SPDX-License-Identifier: Apache-2.0
"""One file of a bag: what the readers of both formats have, QoS profiles as other tools wrote them, search by time."""

import math
from abc import ABC, abstractmethod
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Collection, Iterator, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

from rosbags.rosbag2.errors import ReaderError
from rosbags.rosbag2.metadata import dump_qos_v9, parse_qos

from drill_twin.core.files.yaml_reader import YamlError, plain_yaml
from drill_twin.io.bag.metadata import Qos, RecordedTopic
from drill_twin.io.bag.reading.decompression import LARGEST_CHUNK, of_zstd
from drill_twin.io.messages.stamps import seconds
from drill_twin.io.messages.topics import TOPICS, TWIN_SCENE

LATCHED = tuple(name for name, topic in TOPICS.items() if topic.latched)
"""Ends of the names of topics whose messages are read wherever they are."""
MOST_LATCHED = 50
"""Number of messages, or of chunks with them, that are read of a latched topic."""
_MARGIN = 1.0  # s by which topics may come after one another
_LARGEST = 20_000  # characters of QoS profiles; one has 400


class BagFile(ABC):
    """Reader of one file of a bag, complete or damaged."""

    def __init__(
        self,
        path: Path,
        name: Path | None = None,
        *,
        compressed_messages: bool = False,
        window: tuple[float, float] | None = None,
    ) -> None:
        """Open a file and find its topics.

        Args:
            path: The file.
            name: Name of the file in messages, if the file was decompressed from another file.
            compressed_messages: True if rosbag2 compressed each message.
            window: Header stamps [s] between which messages are wanted; others may come with them. None: all.

        Raises:
            BagError: The file is not of its format, or is a damaged SQLite file.
        """
        self.path, self.title, self._compressed = path, name or path, compressed_messages
        self.topics: dict[str, RecordedTopic] = {}
        """Topics by name, including topics without messages."""
        self.start: int | None = None
        """Earliest time of recording [ns]; None without messages."""
        self.end: int | None = None
        """Latest time of recording [ns]."""
        self.damage: list[str] = []
        """Sentences on missing or damaged parts; empty for a complete file."""
        self.notes: list[str] = []
        """Sentences on what is unusual and harmless."""
        self.temporary: object = None
        """Temporary file that `path` names, removed with this reader."""
        self._open(window)

    @abstractmethod
    def _open(self, window: tuple[float, float] | None) -> None:
        """Find topics and times of recording, and what holds the messages of a window."""

    @abstractmethod
    def messages(self, topics: Collection[str] | None = None) -> Iterator[tuple[str, int, bytes]]:
        """Topic, time of recording [ns] and CDR of each message on these topics; None: on all.

        Raises:
            BagError: The file cannot be read, or is not of its format.
        """

    def _has_several_runs(self) -> bool:
        """Check whether there are several scenes: times then need not rise from run to run."""
        return any(topic.count > 1 for name, topic in self.topics.items() if name.endswith(TWIN_SCENE))

    def _message(self, raw: bytes) -> bytes:
        """CDR of a message as it is stored."""
        return of_zstd(raw, LARGEST_CHUNK) if self._compressed else raw


def blocks_between(total: int, begin: float, end: float, stamps_at: Callable[[int], Sequence[int]]) -> range:
    """Numbers of the blocks with header stamps between two times, and of their neighbours.

    Recorded and header time may differ by any amount, but both rise, so that a bisection finds the ends.

    Args:
        total: Number of blocks.
        begin: Earliest stamp [s].
        end: Latest stamp [s].
        stamps_at: Header stamps [ns] in the block of a number.
    """

    def time_from(k: int) -> float:
        """Median header stamp [s] of the first block from a number on that has any."""
        stamps = next((found for number in range(k, total) if (found := stamps_at(number))), None)
        return math.inf if stamps is None else seconds(sorted(stamps)[len(stamps) // 2])

    first = bisect_left(range(total), begin - _MARGIN, key=time_from) if begin > -math.inf else 0
    last = bisect_right(range(total), end + _MARGIN, lo=first, key=time_from) if end < math.inf else total
    return range(max(first - 1, 0), min(last + 1, total))


@lru_cache(maxsize=64)
def qos_profiles(text: str) -> tuple[Qos, ...]:
    """QoS profiles in the format of version 9; empty where another tool wrote another format."""
    if len(text) > _LARGEST:
        return ()
    try:
        content: Any = plain_yaml(text, "QoS profiles")
        return tuple(dict(profile) for profile in dump_qos_v9(parse_qos(content)))
    except (YamlError, ReaderError, KeyError, TypeError, AttributeError, ValueError):
        return ()
