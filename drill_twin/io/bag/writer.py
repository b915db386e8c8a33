# SPDX-License-Identifier: Apache-2.0
"""Crash-safe writer of bags: whole chunks reach the file every 0.1 s, `metadata.yaml` is written last.

A folder `run` holds `run_0.mcap` and, where the bag is split, `run_1.mcap` and so on; a folder `run_0` holds
`run_0.mcap`, `run_0_1.mcap`, ..., because `ros2 bag reindex` only finds files whose names end in a number.
"""

import re
import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from drill_twin.core import __version__
from drill_twin.core.errors import BagError
from drill_twin.core.files.output import write_whole, writing
from drill_twin.io.bag.file_writer import FileWriter
from drill_twin.io.bag.metadata import RecordedTopic, bag_information, contract_topic, to_yaml
from drill_twin.io.messages.topics import TOPICS

FLUSH_INTERVAL = 0.1
"""Longest time of data in an open chunk [s], which kill -9 would lose."""

_NANOSECONDS = 1e9
_LATCHED = frozenset(name for name, topic in TOPICS.items() if topic.latched)


class BagWriter:
    """Writes CDR messages to a new bag folder; a context manager.

    Leaving the `with` block closes the bag, also after an exception, and keeps the messages recorded so far.
    """

    def __init__(
        self,
        folder: str | Path,
        *,
        topics: Iterable[str | RecordedTopic] = tuple(TOPICS),
        custom_data: Mapping[str, str] | None = None,
        flush_interval: float = FLUSH_INTERVAL,
        largest: float = 0.0,
        longest: float = 0.0,
    ) -> None:
        """Create the folder and its first file.

        Args:
            folder: New folder of the bag; parents are made as needed.
            topics: Topics to record: names of the contract, or descriptions.
            custom_data: Texts by key, stored in `metadata.yaml`.
            flush_interval: Longest time of data that kill -9 loses [s].
            largest: Size at which the bag is split [bytes]; 0: no split.
            longest: Time of recording at which the bag is split [s]; 0: no split.

        Raises:
            BagError: The folder exists or cannot be written.
        """
        self.folder = Path(folder)
        self._custom_data = {"drill_twin_version": __version__, **(custom_data or {})}
        self._flush_interval = flush_interval
        self._largest, self._longest = largest, longest
        described = (contract_topic(topic) if isinstance(topic, str) else replace(topic, count=0) for topic in topics)
        self._topics = {topic.name: topic for topic in described}
        self._files = [_first_file(self.folder, self._topics.values())]
        self._closed = False
        self._latched: dict[str, tuple[int, bytes]] = {}  # the last messages, without which a new file says little
        self.damage: list[str] = []
        """Sentences on files that another program changed while they were recorded."""
        self.flush()

    @property
    def file(self) -> Path:
        """Path of the file that is being written."""
        return self._files[-1].path

    @property
    def files(self) -> int:
        """Number of files so far."""
        return len(self._files)

    @property
    def lost(self) -> int:
        """Messages written that are not in the bag, or may not be: the disk failed, or another program changed it."""
        return sum(file.lost for file in self._files)

    @property
    def counts(self) -> dict[str, int]:
        """Messages written so far, by topic."""
        return {name: topic.count for name, topic in self._topics.items()}

    def add_topic(self, topic: RecordedTopic) -> None:
        """Register a topic before its first message.

        Raises:
            BagError: The topic is registered with another type.
        """
        if (known := self._topics.get(topic.name)) is None:
            self._topics[topic.name] = topic
            self._files[-1].add_topic(topic)
        elif known.type_name != topic.type_name:
            raise BagError(
                f"{self.folder}: expected {topic.name} as {known.type_name} throughout, found {topic.type_name}"
            )

    def write(self, topic: str, stamp: int, raw: bytes) -> None:
        """Record one message.

        Args:
            topic: Name of a registered topic.
            stamp: Time of the recording [ns]: of reception, or simulated time in a run without ROS.
            raw: The message in CDR.

        Raises:
            BagError: The topic is not registered, the bag is closed, or the file cannot be written.
        """
        self.write_all([(topic, stamp, raw)])

    def write_all(self, messages: Sequence[tuple[str, int, bytes]]) -> None:
        """Record messages, each as `write`; a bag may be split before the first message.

        Raises:
            BagError: As `write`; no message is recorded if the topic or the stamp of one is refused.
        """
        if self._closed:
            raise BagError(f"{self.folder}: expected an open bag, found it closed; open a new one")
        for topic, stamp, _ in messages:
            self._check(topic, stamp)
        if not messages:
            return
        try:
            if self._is_full(messages[0][1]):
                self._files[-1].finish(self._information())
                self._open_next()
            numbered = []
            for topic, stamp, raw in messages:
                recorded = self._topics[topic]
                recorded.count += 1
                numbered.append((topic, stamp, raw, recorded.count))
                if topic in _LATCHED:
                    self._latched[topic] = stamp, raw
            self._files[-1].write(numbered)
            self.flush_if_due()
        except BagError:
            self._closed = True
            raise

    def _check(self, topic: str, stamp: int) -> None:
        if topic not in self._topics:
            raise BagError(
                f"{self.folder}: expected one of {', '.join(self._topics)}, found {topic}; add the topic first"
            )
        if stamp < 0:
            raise BagError(f"{self.folder}: expected a stamp of 0 ns or later on {topic}, found {stamp} ns")

    def flush_if_due(self) -> None:
        """Flush if the interval is over; to be called from an idle loop, since only `write` calls it otherwise.

        Raises:
            BagError: The file cannot be written.
        """
        if time.monotonic() - self._flushed >= self._flush_interval:
            self.flush()

    def flush(self) -> None:
        """Pass all messages so far to the operating system; kill -9 no longer loses them.

        Where another program has cut, replaced or removed the file, the recording goes on in a new file.

        Raises:
            BagError: The file cannot be written.
        """
        try:
            self._files[-1].flush()
            self._flushed = time.monotonic()
            if change := self._files[-1].change():
                self._go_on_after(change)
        except BagError:
            self._closed = True
            raise

    def close(self) -> None:
        """Finish the file and write `metadata.yaml`; a second call has no effect.

        Raises:
            BagError: The file cannot be written, or another program changed a file of the bag meanwhile.
        """
        if self._closed:
            return
        self.flush()
        self._closed = True
        information = self._information()
        self._files[-1].finish(information)
        try:
            write_whole(self.folder / "metadata.yaml", to_yaml({"rosbag2_bagfile_information": information}))
        except OSError as error:
            raise self._files[-1].broken(error) from error
        if self.damage:
            raise BagError(f"{'; '.join(self.damage)}; what is still there can be read")

    def _go_on_after(self, change: str) -> None:
        file = self._files[-1]
        found = f"{file.path}: expected the bag that is being recorded, {change}"
        file.abandon()
        if not self.folder.is_dir():
            for one in self._files:
                one.lost = one.count
            raise BagError(f"{found}; record again: the folder is gone with {self.lost} messages")
        self.damage.append(f"{found}: up to {file.count} messages are lost")
        self._open_next()
        for topic, (stamp, raw) in self._latched.items():
            self._files[-1].write([(topic, stamp, raw, self._topics[topic].count)])

    def _is_full(self, stamp: int) -> bool:
        file = self._files[-1]
        too_large = self._largest > 0.0 and file.size >= self._largest
        too_long = self._longest > 0.0 and stamp - (file.start or 0) >= self._longest * _NANOSECONDS
        return file.start is not None and (too_large or too_long)

    def _open_next(self) -> None:
        stem = self._files[0].path.stem if re.search(r"_\d+$", self.folder.name) else self.folder.name
        path = self.folder / f"{stem}_{len(self._files)}.mcap"
        try:
            self._files.append(FileWriter(path, self._topics.values()))
        except OSError as error:
            raise BagError(
                f"{path}: expected to go on in a new file of the bag, found {error.strerror or error}; "
                "what was written so far can be read"
            ) from error
        self.flush()

    def _information(self) -> dict[str, Any]:
        files = [(file.path.name, file.start or 0, file.end, file.count) for file in self._files]
        return bag_information(files, list(self._topics.values()), self._custom_data)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def _first_file(folder: Path, topics: Iterable[RecordedTopic]) -> FileWriter:
    name = folder.name if re.search(r"_\d+$", folder.name) else f"{folder.name}_0"
    with writing(folder, "the bag", "choose another folder"):
        try:
            folder.mkdir(parents=True)
        except FileExistsError as error:
            raise BagError(
                f"{folder}: expected a new folder for the bag, found a folder that exists; choose another or remove it"
            ) from error
        return FileWriter(folder / f"{name}.mcap", topics)
