# SPDX-License-Identifier: Apache-2.0
"""Files of a bag folder: search, order, and choice of the reader for each."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import yaml

from drill_twin.errors import BagError
from drill_twin.io.bag.mcap_file import McapFile
from drill_twin.io.bag.rosbags_file import RosbagsFile

_SUFFIXES = (".mcap", ".db3", ".zstd")

BagFile = McapFile | RosbagsFile


def bag_path(path: str | Path) -> Path:
    """Bag in the folder of a run (`out/run` -> `out/run/bag_0`); any other path unchanged."""
    folder = Path(path)
    inside = folder / "bag_0"
    return inside if inside.is_dir() and not [*folder.glob("*.mcap"), *folder.glob("*.db3")] else folder


def open_files(path: Path) -> tuple[list[BagFile], list[str]]:
    """Readers of the files of a bag, and sentences on empty files that a killed writer left.

    Raises:
        BagError: The path does not exist, cannot be read, or holds no bag.
    """
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
    empty_files = [f"{file.name} is empty: its writer was killed as it began" for file in empty]
    return [_open_file(file) for file in files if file not in empty], empty_files


def _open_file(path: Path) -> BagFile:
    return RosbagsFile(path) if path.suffix == ".db3" else McapFile(path)


def _needs_rosbags(folder: Path, files: Sequence[Path]) -> bool:
    """True if the folder must be read through `metadata.yaml`: sqlite3, or compression by rosbag2."""
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


def _natural(path: Path) -> list[tuple[int, str]]:
    """Sort key of the files of a split bag: `run_2` before `run_10`."""
    return [(int(part), "") if part.isdigit() else (-1, part) for part in re.split(r"(\d+)", path.name)]


def _inside(path: Path) -> str:
    """Content of a folder that is not a bag, for messages; names a bag one level deeper."""
    entries = sorted(path.iterdir())
    for entry in entries:
        if entry.is_dir() and any(file.suffix in _SUFFIXES for file in entry.iterdir()):
            return f"one a level deeper; name {entry}"
    return f"{', '.join(entry.name for entry in entries[:5])}; not a bag" if entries else "nothing in it"
