# SPDX-License-Identifier: Apache-2.0
"""Write a bag that survives its writer: whole chunks reach the file every 0.1 s, `metadata.yaml` comes last.

A folder `run_0` holds `run_0.mcap` (any other folder `run` holds `run_0.mcap`), because `ros2 bag reindex`
only finds files whose names end in a number.
"""

from __future__ import annotations

import re
import time
from collections.abc import Iterable, Mapping
from contextlib import suppress
from io import BufferedWriter
from pathlib import Path
from types import TracebackType
from typing import Self

from mcap.writer import CompressionType, Writer

from drill_twin import __version__
from drill_twin.bag.metadata import Recorded, bag_information, contract_topic, to_yaml
from drill_twin.errors import BagError
from drill_twin.messages.topics import TOPICS

FLUSH_INTERVAL = 0.1
"""Longest time [s] of data in an open chunk, which kill -9 would lose."""

_CHUNK_SIZE = 256 * 1024


class BagWriter:
    """Streams CDR messages to a new bag folder; a context manager.

    Leaving the `with` block closes the bag, also after an exception: what was recorded is kept.
    """

    def __init__(
        self,
        folder: str | Path,
        *,
        topics: Iterable[str | Recorded] = tuple(TOPICS),
        custom_data: Mapping[str, str] | None = None,
        flush_interval: float = FLUSH_INTERVAL,
    ) -> None:
        """Create the folder and start the file.

        Args:
            folder: New folder of the bag; parents are made as needed.
            topics: Topics to record: names from the contract, or whole descriptions.
            custom_data: Text by key, kept in `metadata.yaml`.
            flush_interval: Longest time [s] of data that kill -9 loses.

        Raises:
            BagError: The folder exists or cannot be written.
        """
        self.folder = Path(folder)
        self.file = self.folder / f"{_numbered(self.folder.name)}.mcap"
        self._stream = _create(self.folder, self.file)
        self._writer = Writer(self._stream, chunk_size=_CHUNK_SIZE, compression=CompressionType.ZSTD)
        self._writer.start(profile="ros2", library=f"drill_twin {__version__}")
        self._custom_data = {"drill_twin_version": __version__, **(custom_data or {})}
        self._flush_interval = flush_interval
        self._flushed = time.monotonic()
        self._topics: dict[str, Recorded] = {}
        self._channels: dict[str, int] = {}
        self._schemas: dict[str, int] = {}
        self._first: int | None = None
        self._last = 0
        self._closed = False
        for topic in topics:
            self.add_topic(contract_topic(topic) if isinstance(topic, str) else topic)
        self.flush()

    @property
    def counts(self) -> dict[str, int]:
        """Messages written so far, by topic."""
        return {name: topic.count for name, topic in self._topics.items()}

    def add_topic(self, topic: Recorded) -> None:
        """Announce a topic before its first message.

        Raises:
            BagError: The topic is there already, with another type.
        """
        known = self._topics.get(topic.name)
        if known is not None:
            if known.type_name != topic.type_name:
                raise BagError(
                    f"{self.folder}: expected {topic.name} as {known.type_name} throughout, found {topic.type_name}"
                )
            return
        if topic.type_name not in self._schemas:
            self._schemas[topic.type_name] = self._writer.register_schema(
                topic.type_name, "ros2msg", topic.definition.encode()
            )
        self._topics[topic.name] = topic
        self._channels[topic.name] = self._writer.register_channel(
            topic.name,
            "cdr",
            self._schemas[topic.type_name],
            {"offered_qos_profiles": to_yaml(list(topic.qos)).strip(), "topic_type_hash": topic.type_hash},
        )

    def write(self, topic: str, stamp: int, raw: bytes) -> None:
        """Record one message.

        Args:
            topic: Topic name, announced before.
            stamp: Time of the recording [ns]: of reception, or simulated time in a run without ROS.
            raw: The message in CDR.

        Raises:
            BagError: The topic was not announced, the bag is closed, or the file cannot be written.
        """
        if self._closed:
            raise BagError(f"{self.folder}: expected an open bag, found it closed; open a new one")
        recorded = self._topics.get(topic)
        if recorded is None:
            raise BagError(
                f"{self.folder}: expected one of {', '.join(self._topics)}, found {topic}; add_topic it first"
            )
        if stamp < 0:
            raise BagError(f"{self.folder}: expected a stamp of 0 ns or later on {topic}, found {stamp} ns")
        self._first = stamp if self._first is None else min(self._first, stamp)
        self._last = max(self._last, stamp)
        recorded.count += 1
        try:
            self._writer.add_message(self._channels[topic], stamp, raw, stamp, recorded.count)
        except OSError as error:
            raise self._broken(error) from error
        self.flush_if_due()

    def flush_if_due(self) -> None:
        """Flush when the interval is over; `write` does it too, call it from an idle loop.

        Raises:
            BagError: The file cannot be written.
        """
        if time.monotonic() - self._flushed >= self._flush_interval:
            self.flush()

    def flush(self) -> None:
        """Hand all messages so far to the operating system; kill -9 cannot lose them any more.

        Raises:
            BagError: The file cannot be written.
        """
        try:
            self._writer.flush()  # type: ignore[no-untyped-call]
        except OSError as error:
            raise self._broken(error) from error
        self._flushed = time.monotonic()

    def close(self) -> None:
        """Finish the file and write `metadata.yaml`; a second call does nothing.

        Raises:
            BagError: The file cannot be written.
        """
        if self._closed:
            return
        self._closed = True
        information = bag_information(
            self.file.name, list(self._topics.values()), self._first or 0, self._last, self._custom_data
        )
        try:
            self._writer.flush()  # type: ignore[no-untyped-call]
            self._writer.add_metadata("rosbag2", {"serialized_metadata": to_yaml(information).strip()})
            self._writer.finish()  # type: ignore[no-untyped-call]
            self._stream.close()
            unfinished = self.folder / "metadata.yaml.tmp"
            unfinished.write_text(to_yaml({"rosbag2_bagfile_information": information}), "utf-8")
            unfinished.replace(self.folder / "metadata.yaml")
        except OSError as error:
            raise self._broken(error) from error

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _broken(self, error: OSError) -> BagError:
        self._closed = True
        with suppress(OSError):  # the same failure once more
            self._stream.close()
        return BagError(
            f"{self.file}: expected to go on writing the bag, found {error.strerror or error}; "
            "make room there or choose another folder; what was written so far can be read"
        )


def _numbered(name: str) -> str:
    return name if re.search(r"_\d+$", name) else f"{name}_0"


def _create(folder: Path, file: Path) -> BufferedWriter:
    try:
        folder.mkdir(parents=True)
        return file.open("xb")
    except FileExistsError as error:
        raise BagError(
            f"{folder}: expected a new folder for the bag, found one that exists; choose another or remove it"
        ) from error
    except OSError as error:
        raise BagError(
            f"{folder}: expected a place to write the bag, found {error.strerror or error}; choose another folder"
        ) from error
