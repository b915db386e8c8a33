# SPDX-License-Identifier: Apache-2.0
"""The folder of the page: its scenes and results, new names in it, and files that a browser may open."""

import os
import re
import time
from collections.abc import Collection
from contextlib import suppress
from itertools import count
from pathlib import Path
from typing import Any

from drill_twin.core.errors import ArgumentError
from drill_twin.core.files.output import writing
from drill_twin.scene import presets, well_scenes

TYPES = {".html": "text/html", ".png": "image/png", **dict.fromkeys((".json", ".csv", ".yaml", ".yml"), "text/plain")}
"""Type of each file that a browser may open, by its suffix."""
LARGEST = 100_000_000
"""Size of a file that a browser may open [byte]. Chosen, not measured."""
DEPTH = 4
"""Folders below the folder of the page in which scenes and results are looked for."""
MOST = 20_000
"""Files and folders that are looked at. Chosen, not measured."""
FRESH = 2.0
"""Time for which a list holds [s]."""
_SCENE = re.compile(rb"^(?:string|hole|base)\s*:", re.MULTILINE)
_HEAD = 100_000  # bytes of a file that may be a scene; a description has 5,000 characters at most


class Folder:
    """Folder of the page; its files have names from it, with / between the parts."""

    def __init__(self, root: Path) -> None:
        """Look at nothing yet.

        Args:
            root: The folder.
        """
        self.root, self.installed = root.resolve(), [*presets(), *well_scenes()]
        self._listed, self._until = dict[str, Any](), 0.0

    def listed(self) -> dict[str, Any]:
        """Scenes, and results with their files, the newest first; not older than `FRESH`."""
        if time.monotonic() > self._until:
            self._listed, self._until = self._scan(), time.monotonic() + FRESH
        return self._listed

    def inside(self, name: str) -> Path:
        """Path of a file or folder.

        Raises:
            ArgumentError: It lies elsewhere, perhaps behind a link, or its name is like an option.
        """
        try:
            path = (self.root / name).resolve()
        except (OSError, ValueError, RuntimeError):  # too long, a null character, a circle of links
            path = Path()
        if name.startswith("-") or not path.is_relative_to(self.root):
            raise ArgumentError(f"expected a file or folder in {self.root}, found {name[:200]}")
        return path

    def fresh(self, name: str, suffix: str = "", taken: Collection[str] = (), content: bytes = b"") -> str:
        """A name like this one of no file or folder; with content, of a file that has it already, or is written.

        Args:
            name: Name without its suffix.
            suffix: Suffix, after a number if the name is taken.
            taken: Names of what is being made.
            content: Content of the file.

        Raises:
            BagError: It cannot be written.
        """
        with writing(f"{name}{suffix}", "a file", "choose another folder"):
            for number in count(1):
                path = self.inside(new := f"{name}{f'_{number}' if number > 1 else ''}{suffix}")
                if content and path.is_file() and path.read_bytes() == content:
                    return new
                if new not in taken and not path.exists():
                    break
            if content:
                path.write_bytes(content)
        return new

    def content(self, name: str) -> tuple[str, bytes] | None:
        """Type and content of a file; None for what a browser may not open."""
        with suppress(ArgumentError, OSError):
            path = self.inside(name)
            if path.suffix in TYPES and path.is_file() and path.stat().st_size <= LARGEST:
                return TYPES[path.suffix], path.read_bytes()
        return None

    def _scan(self) -> dict[str, Any]:
        scenes, results, seen = list[str](), list[dict[str, Any]](), 0
        for at, folders, files in os.walk(self.root):
            place, seen = Path(at).relative_to(self.root), seen + len(folders) + len(files)
            if seen > MOST:
                break
            bag = "bag_0" in folders or "metadata.yaml" in files
            folders[:] = [
                name for name in folders
                if name.isprintable() and name[0] != "." and name != "bag_0" and len(place.parts) < DEPTH
            ]  # fmt: skip
            names = sorted(
                (name for name in files if name.isprintable() and Path(name).suffix in TYPES),
                key=lambda name: ([*TYPES].index(Path(name).suffix), name),
            )
            scenes += [_named(place / name) for name in names if _is_scene(Path(at, name))]
            made = {f"{Path(name).stem}.json" for name in names if name.endswith((".html", ".png"))}
            if bag or (made | {"report.html", "states.json"}) & set(names):
                results.append({"name": _named(place), "bag": bag, "files": names, "time": Path(at).stat().st_mtime})
        results.sort(key=lambda result: -result["time"])
        return {"scenes": sorted(scenes), "results": results, "cut": seen > MOST}


def _is_scene(path: Path) -> bool:
    """True for a YAML file with a part of a scene, right or not."""
    with suppress(OSError):
        if path.suffix in {".yaml", ".yml"} and path.is_file():
            with path.open("rb") as stream:
                return bool(_SCENE.search(stream.read(_HEAD)))
    return False


def _named(place: Path) -> str:
    """Name of a path in a command, which is neither an option nor the word for the running twin."""
    return f"./{place}" if str(place).startswith("-") or str(place) == "live" else str(place)
