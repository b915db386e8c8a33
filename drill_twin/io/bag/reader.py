# SPDX-License-Identifier: Apache-2.0
"""Open a bag, whole or left by a killed writer, and say plainly what is wrong with any other folder."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Sequence
from pathlib import Path

import yaml

from drill_twin.errors import BagError
from drill_twin.io.bag.mcap_file import McapFile
from drill_twin.io.bag.metadata import Recorded
from drill_twin.io.bag.rosbags_file import RosbagsFile
from drill_twin.io.messages.decode import read_string
from drill_twin.io.messages.topics import GENERIC, TOPICS, TWIN_SCENE

_SUFFIXES = (".mcap", ".db3", ".zstd")


class Bag:
    """A bag of this package, ready to be read any number of times.

    `damage` says in words what is missing; a bag is `truncated` when its writer never finished it or a part
    of it is damaged. What is there can be read all the same.
    """

    def __init__(self, path: str | Path) -> None:
        """Open a bag folder or a single file.

        Args:
            path: Bag folder, `.mcap` or `.db3` file.

        Raises:
            BagError: There is none, it is not a bag, it is empty, or it is not from this package.
        """
        self.path = Path(path)
        self._files, unbegun = _open_files(self.path)
        self.damage: list[str] = [*(text for file in self._files for text in file.damage), *unbegun]
        self.topics: dict[str, Recorded] = _merged(self._files)
        starts = [file.start for file in self._files if file.start is not None]
        ends = [file.end for file in self._files if file.end is not None]
        if not starts:
            raise BagError(f"{self.path}: expected a bag with messages, found none{self._because()}; record it again")
        self.start: int = min(starts)
        self.end: int = max(ends)
        self._check_topics()

    @property
    def truncated(self) -> bool:
        """Whether something is missing at the end, or was damaged."""
        return bool(self.damage)

    @property
    def message_count(self) -> int:
        """Messages in the bag, all topics."""
        return sum(topic.count for topic in self.topics.values())

    def messages(self, topics: Collection[str] | None = None) -> Iterator[tuple[str, int, bytes]]:
        """Topic, time of recording [ns] and CDR of each message, in recorded order.

        Args:
            topics: Only these topics; all where none.
        """
        wanted = None if topics is None else frozenset(topics)
        for file in self._files:
            yield from file.messages(wanted)

    def last(self, topic: str) -> bytes | None:
        """CDR of the last message on a topic, if there is one."""
        raw = None
        for _, _, raw in self.messages((topic,)):  # noqa: B007  the last one is what we want
            pass
        return raw

    def scene(self) -> str:
        """The resolved scene (YAML, with its `run` block) that the bag was made from.

        Raises:
            BagError: The bag does not hold one.
        """
        raw = self.last(TWIN_SCENE)
        if raw is None:
            raise BagError(f"{self.path}: expected the scene on {TWIN_SCENE}, found no message there; name the scene")
        return read_string(raw)

    def _because(self) -> str:
        return f" ({'; '.join(self.damage)})" if self.damage else ""

    def _check_topics(self) -> None:
        for name, topic in self.topics.items():
            if name in TOPICS and topic.type_name != TOPICS[name].type_name:
                raise BagError(
                    f"{self.path}: expected {name} as {TOPICS[name].type_name}, found {topic.type_name}; "
                    "the bag is of another package or version"
                )
        if not any(name in TOPICS and name not in GENERIC and topic.count for name, topic in self.topics.items()):
            found = ", ".join(f"{name} ({topic.type_name})" for name, topic in sorted(self.topics.items()))
            raise BagError(
                f"{self.path}: expected topics of drill_twin such as /string/poses "
                f"or /marks/state, found only {found}; the bag is of another package"
            )


BagFile = McapFile | RosbagsFile


def _open_files(path: Path) -> tuple[list[BagFile], list[str]]:
    """The files of a bag; and in words those of a split bag whose writer was killed as it began them."""
    if not path.exists():
        raise BagError(f"{path}: expected a bag folder or file, found nothing there; check the path")
    if path.is_file():
        return [_open_file(path)], []
    try:
        files = sorted((file for file in path.iterdir() if file.suffix in _SUFFIXES), key=_natural)
    except OSError as error:
        raise BagError(f"{path}: expected a readable bag folder, found {error.strerror or error}") from error
    if not files:
        raise BagError(f"{path}: expected a bag (.mcap or .db3) in this folder, found {_inside(path)}")
    if _needs_rosbags(path, files):
        return [RosbagsFile(path)], []
    empty = [file for file in files[1:] if not file.stat().st_size]
    unbegun = [f"{file.name} is empty: its writer was killed as it began" for file in empty]
    return [_open_file(file) for file in files if file not in empty], unbegun


def _open_file(path: Path) -> BagFile:
    return RosbagsFile(path) if path.suffix == ".db3" else McapFile(path)


def _needs_rosbags(folder: Path, files: Sequence[Path]) -> bool:
    """Whether `metadata.yaml` says more than plain MCAP files do: sqlite3, or compression by rosbag2."""
    metadata = folder / "metadata.yaml"
    if any(file.suffix == ".zstd" for file in files):
        return True
    if not metadata.exists():
        return False
    if any(file.suffix == ".db3" for file in files):
        return True
    try:
        mode = yaml.safe_load(metadata.read_text("utf-8"))["rosbag2_bagfile_information"].get("compression_mode", "")
    except (OSError, yaml.YAMLError, UnicodeError, KeyError, TypeError, AttributeError):
        return False  # MCAP files describe themselves
    return str(mode).lower() in {"message", "file"}


def _merged(files: Sequence[BagFile]) -> dict[str, Recorded]:
    topics: dict[str, Recorded] = {}
    for file in files:
        for name, topic in file.topics.items():
            if name in topics:
                topics[name].count += topic.count
            else:
                topics[name] = topic
    return topics


def _natural(path: Path) -> list[tuple[int, str]]:
    """Order of split bags: `run_2` before `run_10`."""
    return [(int(part), "") if part.isdigit() else (-1, part) for part in re.split(r"(\d+)", path.name)]


def _inside(path: Path) -> str:
    """What a folder that is not a bag holds, with a hint where a bag lies one level deeper."""
    entries = sorted(path.iterdir())
    for entry in entries:
        if entry.is_dir() and any(file.suffix in _SUFFIXES for file in entry.iterdir()):
            return f"one a level deeper; name {entry}"
    return f"{', '.join(entry.name for entry in entries[:5])}; not a bag" if entries else "nothing in it"
