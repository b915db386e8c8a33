# SPDX-License-Identifier: Apache-2.0
"""Checkpoint file of a run, from which it is resumed bit for bit.

The file is an `.npz` of plain arrays without pickles: the resolved scene, the version, and all arrays of the twin's
state. A new file replaces the previous file atomically. When a run fails, a checkpoint of the last good frame is
saved, with the last second of states and the error.
"""

import json
import lzma
import math
import stat
import struct
import zipfile
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from io import BytesIO
from itertools import zip_longest
from pathlib import Path
from typing import Any, Self

import numpy as np

from drill_twin.core import __version__
from drill_twin.core.arrays import Array
from drill_twin.core.errors import CheckpointError, DrillTwinError, StoppedError, shortened
from drill_twin.core.files.foreign_file import ForeignFile
from drill_twin.core.files.json_files import read_json
from drill_twin.core.files.output import whole_file, write_whole
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.scene import Scene, parse_scene
from drill_twin.scene.set_points.command import Command

_FORMAT = 1
_HEADER = "head"
_HEAD_KEYS = {"format", "version", "time", "set_points", "scene"}
_LARGEST_HEADER = 2_000_000  # bytes; the scene takes most of it
_LARGEST_SIZE = 128 * 1024 * 1024  # bytes of all arrays; a string of 10 000 elements needs 3 MB
_FILE = ForeignFile("a checkpoint", _LARGEST_SIZE, CheckpointError)
_DAMAGED = (
    OSError, ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile, NotImplementedError, RuntimeError,
    ArithmeticError, MemoryError, struct.error, zlib.error, lzma.LZMAError,
)  # fmt: skip
"""Raised by zipfile and numpy on damaged files."""

Arrays = Mapping[str, Array]


@dataclass(frozen=True, eq=False)
class Checkpoint:
    """Content of a checkpoint file."""

    scene: str
    """Resolved scene (YAML)."""
    time: float
    """Simulated time [s]."""
    command: Command
    """Set-points in force."""
    arrays: Arrays
    """Arrays of the twin's state, by name."""

    @classmethod
    def of(cls, twin: Twin, command: Command) -> Self:
        """Make the checkpoint of a twin and the set-points in force."""
        return cls(twin.scene.to_yaml(), twin.time, command, twin.checkpoint())

    def save(self, path: str | Path) -> None:
        """Write the file atomically, in a folder that exists; of files there it replaces a checkpoint only.

        Raises:
            CheckpointError: It cannot be written; a previous file is unchanged.
        """
        target = Path(path)
        head = {
            "format": _FORMAT,
            "version": __version__,
            "time": self.time,
            "set_points": self.command,
            "scene": self.scene,
        }
        content: dict[str, Any] = {_HEADER: np.frombuffer(json.dumps(head).encode(), np.uint8), **self.arrays}
        try:
            _refuse_other_file(target)
            with whole_file(target) as stream:
                np.savez(stream, **content)
        except (OSError, ValueError) as error:
            found = getattr(error, "strerror", None) or error
            raise CheckpointError(
                f"{target}: expected a place for the checkpoint, found {found}; free it or name another"
            ) from error

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read a file.

        Raises:
            CheckpointError: No such file, a damaged file, or a file of another version.
        """
        try:
            with _FILE.open(path) as stream, zipfile.ZipFile(stream) as archive:
                members = _members(archive)
            head = _head(members.pop(_HEADER))
            if head["format"] != _FORMAT or head["version"] != __version__:
                raise CheckpointError(
                    f"{path}: expected a checkpoint of drill_twin {__version__}, found a checkpoint of "
                    f"{head['version']}; "
                    "start the run afresh, or go on with that version"
                )
            time, command = float(head["time"]), Command(*map(float, head["set_points"]))
            scene = head["scene"]
        except _DAMAGED as error:
            raise CheckpointError(
                f"{path}: expected a whole checkpoint of drill_twin, found {type(error).__name__}: "
                f"{shortened(str(error), 200)}; start the run afresh"
            ) from error
        if not (math.isfinite(time) and command.is_finite()) or not isinstance(scene, str):
            found = f"{time:g} s, {tuple(command)}"
            raise CheckpointError(f"{path}: expected finite numbers and a scene, found {found}; start the run afresh")
        return cls(scene, time, command, members)

    def twin(self) -> Twin:
        """Make a twin of the checkpoint's scene in its state.

        Raises:
            CheckpointError: Scene or arrays are damaged.
        """
        try:
            scene = parse_scene(self.scene, name="the checkpoint's scene")
        except DrillTwinError as error:
            raise CheckpointError(str(error)) from error
        twin = Twin(scene)
        self.restore(twin)
        return twin

    def restore(self, twin: Twin) -> None:
        """Restore the state of a twin of the same scene; on an error it is unchanged.

        Raises:
            CheckpointError: The twin is of another scene, or has other arrays.
        """
        self._refuse_other(twin.scene)
        expected = {name: array.shape for name, array in twin.checkpoint().items()}
        found = {name: array.shape for name, array in self.arrays.items()}
        if found != expected:
            odd = sorted(name for name in {*expected, *found} if expected.get(name) != found.get(name))
            raise CheckpointError(
                f"expected a checkpoint of this twin, found other arrays: {', '.join(odd)}; start the run afresh"
            )
        twin.restore(self.arrays)

    def _refuse_other(self, scene: Scene) -> None:
        wanted, found = scene.to_yaml().splitlines(), self.scene.splitlines()
        if wanted == found:
            return
        pairs = enumerate(zip_longest(wanted, found, fillvalue=""), 1)
        number, (mine, theirs) = next((n, pair) for n, pair in pairs if pair[0] != pair[1])
        raise CheckpointError(
            f"expected a checkpoint of this scene, {scene.name}, found a checkpoint of another scene: line {number} of "
            f'the resolved scene is "{theirs.strip()}" there and "{mine.strip()}" here; load that scene, or start the '
            "run afresh"
        )


def _refuse_other_file(path: Path) -> None:
    """Refuse to replace what is no checkpoint, as its head tells: a spreadsheet is a ZIP too."""
    if not path.exists():
        return
    if not stat.S_ISREG(path.stat().st_mode):
        raise ValueError("a folder, a pipe or a device there")
    try:
        with zipfile.ZipFile(path) as archive:
            size = archive.getinfo(f"{_HEADER}.npy").file_size
            known = size <= _LARGEST_HEADER and _head(_array(archive.read(f"{_HEADER}.npy"))).keys() >= _HEAD_KEYS
    except (*_DAMAGED, DrillTwinError):
        known = False
    if not known:
        raise ValueError("another file there, which is not replaced")


def _head(array: Array) -> dict[str, Any]:
    head = read_json(array.tobytes(), largest=_LARGEST_HEADER)
    if not isinstance(head, dict):
        raise ValueError("a head that is no table")  # noqa: TRY004 - told as damage
    return head


def _members(archive: zipfile.ZipFile) -> dict[str, Array]:
    """Read all arrays of an archive, after a check of their size in bytes."""
    size = sum(member.file_size for member in archive.infolist())
    if size > _LARGEST_SIZE:
        raise ValueError(f"{size} bytes where at most {_LARGEST_SIZE} can be meant")
    return {member.filename.removesuffix(".npy"): _array(archive.read(member)) for member in archive.infolist()}


def _array(data: bytes) -> Array:
    stream = BytesIO(data)
    found: Array = np.lib.format.read_array(stream, allow_pickle=False)
    if found.dtype not in {np.dtype(np.float64), np.dtype(np.uint8)} or stream.read(1):
        raise ValueError(f"an array of {found.dtype} in {len(data)} bytes")
    return found


CHECKPOINT, LAST_SECOND, REASON = "checkpoint.npz", "last_second.npz", "why.txt"


def save_failure(folder: str | Path, twin: Twin, command: Command, error: StoppedError) -> str:
    """Write `checkpoint.npz`, `last_second.npz` (`time`, `u`, `v`, `distance_from_bit`) and `why.txt`.

    Args:
        folder: Target folder; created if it is missing.
        twin: The twin, restored to its last good frame.
        command: The set-points in force.
        error: The reason of the stop.

    Returns:
        A sentence that names the folder, or the error if the files could not be written; files that cannot be
        written never raise, so that the reason of the stop is not hidden.
    """
    target = Path(folder)
    try:
        target.mkdir(parents=True, exist_ok=True)
        Checkpoint.of(twin, command).save(target / CHECKPOINT)
        time, u, v = twin.last_second()
        with whole_file(target / LAST_SECOND) as stream:
            np.savez(stream, time=time, u=u, v=v, distance_from_bit=twin.rod.arc)
        write_whole(target / REASON, f"{error}\n")
    except (CheckpointError, OSError) as trouble:
        return f"the state could not be kept: {trouble}"
    return f"the last good state and the last second before it are kept in {target}"
