# SPDX-License-Identifier: Apache-2.0
"""A run in a file: all that decides how it goes on, so that it goes on bit for bit as if it had never stopped.

The file is an `.npz` of plain arrays, never pickled: the resolved scene, the version, and every array that the twin
remembers. It replaces the one before in one move, so that a writer that is killed leaves a whole one.
"""

from __future__ import annotations

import json
import math
import os
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any, Self

import numpy as np

from drill_twin import __version__
from drill_twin.base.arrays import Array
from drill_twin.errors import CheckpointError, DrillTwinError
from drill_twin.scene import Scene, parse_scene
from drill_twin.schedule.command import Command
from drill_twin.twin.dynamics import AXIAL
from drill_twin.twin.twin import Twin

_FORMAT = 1
_HEAD = "head"
_LARGEST = 256 * 1024 * 1024  # bytes of all arrays; a string of 10 000 elements needs 3 MB
_BAD = (OSError, ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile, NotImplementedError, RuntimeError)
"""What zipfile and numpy raise on bytes that are not what they should be."""

Arrays = Mapping[str, Array]


@dataclass(frozen=True, eq=False)
class Checkpoint:
    """What a checkpoint file holds."""

    scene: str
    """The resolved scene (YAML)."""
    time: float
    """Simulated time [s]."""
    command: Command
    """The set-points that were in force."""
    arrays: Arrays
    """The twin's memory, by name."""

    @classmethod
    def of(cls, twin: Twin, command: Command) -> Self:
        """The state of a running twin, and the set-points in force."""
        return cls(twin.scene.to_yaml(), twin.time, command, twin.checkpoint())

    def save(self, path: str | Path) -> None:
        """Write it, in place of an older one.

        Raises:
            CheckpointError: It cannot be written; the older one is still there.
        """
        target = Path(path)
        head = {
            "format": _FORMAT,
            "version": __version__,
            "time": self.time,
            "weight_on_bit": self.command.weight_on_bit,
            "rotation": self.command.rotation,
            "scene": self.scene,
        }
        content: dict[str, Any] = {_HEAD: np.frombuffer(json.dumps(head).encode(), np.uint8), **self.arrays}
        unfinished = target.with_name(f"{target.name}.tmp")
        try:
            target.parent.mkdir(parents=True, exist_ok=True)
            with unfinished.open("wb") as stream:
                np.savez(stream, **content)
                stream.flush()
                os.fsync(stream.fileno())
            unfinished.replace(target)
        except OSError as error:
            raise CheckpointError(
                f"{target}: expected a place for the checkpoint, found {error.strerror or error}; "
                "free it or name another"
            ) from error

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read one.

        Raises:
            CheckpointError: There is none, it is damaged, or it is of another version.
        """
        try:
            with zipfile.ZipFile(path) as archive:
                members = _members(archive)
            head = json.loads(members.pop(_HEAD).tobytes())
            if head["format"] != _FORMAT or head["version"] != __version__:
                raise CheckpointError(
                    f"{path}: expected a checkpoint of drill_twin {__version__}, found one of {head['version']}; "
                    "start the run afresh, or go on with that version"
                )
            numbers = [float(head[name]) for name in ("time", "weight_on_bit", "rotation")]
            scene = head["scene"]
        except FileNotFoundError:
            raise CheckpointError(f"{path}: expected a checkpoint, found nothing there; check the path") from None
        except _BAD as error:
            raise CheckpointError(
                f"{path}: expected a whole checkpoint of drill_twin, found {_words(error)}; start the run afresh"
            ) from error
        if not all(map(math.isfinite, numbers)) or not isinstance(scene, str):
            raise CheckpointError(f"{path}: expected finite numbers and a scene, found {numbers}; start the run afresh")
        return cls(scene, numbers[0], Command(numbers[1], numbers[2]), members)

    def twin(self) -> Twin:
        """A twin of the checkpoint's own scene that goes on from here.

        Raises:
            CheckpointError: Its scene or its arrays are damaged.
        """
        try:
            scene = parse_scene(self.scene, name="the checkpoint's scene")
        except DrillTwinError as error:
            raise CheckpointError(str(error)) from error
        twin = Twin(scene)
        self.restore(twin)
        return twin

    def restore(self, twin: Twin) -> None:
        """Make a twin of the same scene go on from here; it is untouched if that is refused.

        Raises:
            CheckpointError: The twin is of another scene, or the arrays do not fit it.
        """
        self._refuse_other(twin.scene)
        expected = {name: array.shape for name, array in twin.checkpoint().items()}
        found = {name: array.shape for name, array in self.arrays.items()}
        if found != expected and found != {name: shape for name, shape in expected.items() if name != AXIAL}:
            odd = sorted(name for name in {*expected, *found} if expected.get(name) != found.get(name))
            raise CheckpointError(
                f"expected a checkpoint of this twin, found other arrays: {', '.join(odd)}; start the run afresh"
            )
        twin.restore(self.arrays)

    def _refuse_other(self, scene: Scene) -> None:
        wanted, found = scene.to_yaml().splitlines(), self.scene.splitlines()
        if wanted == found:
            return
        length = max(len(wanted), len(found))
        pairs = zip(wanted + [""] * (length - len(wanted)), found + [""] * (length - len(found)), strict=True)
        number, (mine, theirs) = next((n, pair) for n, pair in enumerate(pairs, 1) if pair[0] != pair[1])
        raise CheckpointError(
            f"expected a checkpoint of this scene, {scene.name}, found one of another: line {number} of the resolved "
            f'scene is "{theirs.strip()}" there and "{mine.strip()}" here; load that scene, or start the run afresh'
        )


def _members(archive: zipfile.ZipFile) -> dict[str, Array]:
    """All arrays of an archive, none larger than its bytes, so that a forged size takes no memory."""
    size = sum(member.file_size for member in archive.infolist())
    if size > _LARGEST:
        raise ValueError(f"{size} bytes where at most {_LARGEST} can be meant")
    return {member.filename.removesuffix(".npy"): _array(archive.read(member)) for member in archive.infolist()}


def _array(data: bytes) -> Array:
    stream = BytesIO(data)
    version = np.lib.format.read_magic(stream)
    if version != (1, 0):
        raise ValueError(f"an array of format {version}")
    shape, fortran, kind = np.lib.format.read_array_header_1_0(stream)
    if kind.hasobject or kind not in {np.dtype(np.float64), np.dtype(np.uint8)} or (fortran and len(shape) > 1):
        raise ValueError(f"an array of {kind}")
    content = data[stream.tell() :]
    if math.prod(shape) * kind.itemsize != len(content):
        raise ValueError(f"{len(content)} bytes for an array of {shape}")
    return np.frombuffer(content, kind).reshape(shape)


_LONGEST = 200


def _words(error: BaseException) -> str:
    text = " ".join(str(error).split())[:_LONGEST]  # zipfile quotes headers whole
    return text if text and not isinstance(error, KeyError) else f"{type(error).__name__} {text}".strip()
