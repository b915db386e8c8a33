# SPDX-License-Identifier: Apache-2.0
"""Files of a bag folder: search, order, and choice of the reader for each."""

import re
import stat
import tempfile
from pathlib import Path
from typing import Any

from drill_twin.core.errors import BagError
from drill_twin.core.files.foreign_file import ForeignFile
from drill_twin.core.files.yaml_reader import LARGEST_TEXT, YamlError, plain_yaml
from drill_twin.io.bag.reading.bag_file import BagFile
from drill_twin.io.bag.reading.decompression import DAMAGED, decompress_stream
from drill_twin.io.bag.reading.mcap_file import McapFile
from drill_twin.io.bag.reading.sqlite_file import SqliteFile

_SUFFIXES = (".mcap", ".db3", ".zstd")
_EXPANSION, _EXPANSION_OF_ANY = 50, 64_000_000  # bytes of a decompressed file: per byte, and beyond it

_MOST_LISTED = 1000
_METADATA = ForeignFile("metadata.yaml", LARGEST_TEXT, BagError)

Window = tuple[float, float] | None


def bag_path(path: str | Path) -> Path:
    """Bag in the folder of a run (`out/run` -> `out/run/bag_0`); any other path unchanged."""
    folder = Path(path)
    inside = folder / "bag_0"
    return inside if inside.is_dir() and not [*folder.glob("*.mcap"), *folder.glob("*.db3")] else folder


def open_files(path: Path, window: Window = None) -> tuple[list[BagFile], list[str]]:
    """Readers of the files of a bag, and sentences on empty files that a killed writer left.

    Args:
        path: Folder or file.
        window: Header stamps [s] between which messages are wanted, where an index finds them; None: all.

    Raises:
        BagError: The path does not exist, cannot be read, or holds no bag.
    """
    try:
        kind = path.stat().st_mode
    except FileNotFoundError:
        raise BagError(f"{path}: expected a bag folder or file, found nothing there; check the path") from None
    except (OSError, ValueError) as error:
        raise BagError(f"{path}: expected a readable bag, found {_reason(error)}; check the path") from error
    if not stat.S_ISDIR(kind):
        if not stat.S_ISREG(kind):
            raise BagError(f"{path}: expected a bag folder or file, found a pipe or a device; name a file")
        return [_open_file(path, window)], []
    try:
        files = sorted((file for file in path.iterdir() if file.suffix in _SUFFIXES), key=_natural)
        if not files:
            raise BagError(f"{path}: expected a bag (.mcap or .db3) in this folder, found {_inside(path)}")
        if odd := [file for file in files if not file.is_file()]:
            raise BagError(f"{odd[0]}: expected a file of the bag, found a folder, a pipe or a broken link")
        empty = [file for file in files[1:] if not file.stat().st_size]
    except OSError as error:
        raise BagError(f"{path}: expected a readable bag folder, found {_reason(error)}") from error
    damage = [f"{file.name} is empty: its writer was killed as it began" for file in empty]
    information = _information(path)
    damage += [f"{name} is missing" for name in _missing(path, information)]
    compressed = str(information.get("compression_mode", "")).lower() == "message"
    opened: list[BagFile] = []
    unreadable: list[BagError] = []
    for file in files:
        if file not in empty:
            try:
                opened.append(_open_file(file, window, compressed_messages=compressed))
            except BagError as error:
                unreadable.append(error)
    if not opened:
        raise unreadable[0]
    return opened, [*damage, *(f"left out: {error}" for error in unreadable)]


def _open_file(
    path: Path, window: Window = None, *, name: Path | None = None, compressed_messages: bool = False
) -> BagFile:
    if path.suffix == ".zstd":
        return _open_compressed(path, compressed_messages=compressed_messages)
    kind = SqliteFile if path.suffix == ".db3" else McapFile
    return kind(path, name, compressed_messages=compressed_messages, window=window)


def _open_compressed(path: Path, *, compressed_messages: bool) -> BagFile:
    """Open a file that rosbag2 compressed as a whole, through a temporary file that lives as long as the reader."""
    target = tempfile.NamedTemporaryFile(prefix="drill_twin_", suffix=Path(path.stem).suffix)  # noqa: SIM115
    try:
        with path.open("rb") as source:
            decompress_stream(source, target.file, _EXPANSION * path.stat().st_size + _EXPANSION_OF_ANY)
        target.flush()
    except (OSError, *DAMAGED) as error:
        target.close()
        raise BagError(f"{path}: expected a file compressed by rosbag2, found {_reason(error)}") from error
    opened = _open_file(Path(target.name), name=path, compressed_messages=compressed_messages)
    opened.temporary = target
    return opened


def _information(folder: Path) -> dict[str, Any]:
    """Content of `metadata.yaml`; empty if it is missing or damaged, since the files describe themselves."""
    metadata = folder / "metadata.yaml"
    try:
        content = plain_yaml(_METADATA.text(metadata), metadata.name)
    except (BagError, YamlError):
        return {}
    information = content.get("rosbag2_bagfile_information") if isinstance(content, dict) else None
    return information if isinstance(information, dict) else {}


def _missing(folder: Path, information: dict[str, Any]) -> list[str]:
    """Names of files that the metadata lists and the folder lacks."""
    listed = information.get("relative_file_paths")
    names = [Path(name).name for name in listed if isinstance(name, str)] if isinstance(listed, list) else []
    return [name for name in names[:_MOST_LISTED] if not (folder / name).exists()]


def _reason(error: Exception) -> str:
    return " ".join(str(getattr(error, "strerror", None) or error).split())[:200] or "a damaged one"


def _natural(path: Path) -> list[tuple[int, str]]:
    """Sort key of the files of a split bag: `run_2` before `run_10`."""
    return [(int(part), "") if part.isdecimal() else (-1, part) for part in re.split(r"(\d+)", path.name)]


def _inside(path: Path) -> str:
    """Content of a folder that is not a bag, for messages; names a bag one level deeper."""
    entries = sorted(path.iterdir())[:_MOST_LISTED]
    for entry in entries:
        if entry.is_dir() and any(file.suffix in _SUFFIXES for file in entry.iterdir()):
            return f"a bag a level deeper; name {entry}"
    return f"{', '.join(entry.name for entry in entries[:5])}; not a bag" if entries else "nothing in it"
