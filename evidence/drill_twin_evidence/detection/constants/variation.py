# SPDX-License-Identifier: Apache-2.0
"""Each constant by half and by double, in a fresh process on a copy of the package with one literal edited."""

from __future__ import annotations

import hashlib
import json
import os
import pickle
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

from typing_extensions import TypedDict

import drill_twin
from drill_twin_evidence.detection.constants.literals import Literal
from drill_twin_evidence.detection.constants.outcome import Outcome, material

PACKAGE = Path(drill_twin.__file__).parent
FACTORS = (0.5, 2.0)
"""Factors by which a literal is varied."""
PATIENCE = 900.0
"""Longest time of a variant [s]; one that never ends is a result too. Chosen: ten times a usual variant."""


class Row(TypedDict):
    """A varied literal, or the package as it is under the key `as it is`."""

    key: str
    factor: float
    outcome: Outcome | None
    """None where the varied analysis fails."""
    error: str
    """Last line of the failure."""


class Copy:
    """A copy of the package in a temporary folder, with its own compiled kernels and the records."""

    def __init__(self, folder: Path, each: int) -> None:
        self._place, self._kernels, self._records = folder / "copy", folder / "kernels", folder / "records"
        self._used = folder / "used"
        shutil.copytree(PACKAGE, self._place / PACKAGE.name, ignore=shutil.ignore_patterns("__pycache__"))
        self._kernels.mkdir(mode=0o700)
        self._records.write_bytes(pickle.dumps(material(each)))

    def as_it_is(self) -> Row:
        """Outcome of the package as it is; its kernels are kept for what a variant does not change."""
        return self._run("as it is", 1.0, self._kernels)  # with its bytecode

    def varied(self, literal: Literal, factor: float) -> Row:
        """Outcome with one literal varied; the copy is whole again after it."""
        file = self._place / PACKAGE.name / "whirl" / literal.file
        source = file.read_text("utf-8")
        shutil.copytree(self._kernels, self._used)
        try:
            file.write_text(edited(source, literal, factor), "utf-8")
            return self._run(literal.key, factor, self._used, PYTHONDONTWRITEBYTECODE="1")
        finally:
            file.write_text(source, "utf-8")
            shutil.rmtree(self._used)

    def _run(self, key: str, factor: float, kernels: Path, **more: str) -> Row:
        path = os.pathsep.join([str(self._place), *(one for one in sys.path if one)])
        environment = {**os.environ, **more, "PYTHONPATH": path, "DRILL_TWIN_CACHE": str(kernels)}
        command = [sys.executable, "-m", "drill_twin_evidence.detection.constants.outcome", str(self._records)]
        try:
            done = subprocess.run(
                command, env=environment, cwd=self._place, capture_output=True, text=True, timeout=PATIENCE, check=False
            )
        except subprocess.TimeoutExpired:
            return Row(key=key, factor=factor, outcome=None, error=f"no end within {PATIENCE:g} s")
        if done.returncode:
            last = (done.stderr.strip().splitlines() or [f"exit code {done.returncode}"])[-1]
            return Row(key=key, factor=factor, outcome=None, error=last)
        return Row(key=key, factor=factor, outcome=json.loads(done.stdout.splitlines()[-1]), error="")


@contextmanager
def copy_of_the_package(each: int) -> Iterator[Copy]:
    """A copy of the package in a temporary folder, and records, so many of each kind."""
    with TemporaryDirectory(prefix="constants_") as folder:
        yield Copy(Path(folder), each)


def edited(source: str, literal: Literal, factor: float) -> str:
    """The text of a file with one literal varied.

    Raises:
        ValueError: The literal does not stand in its place.
    """
    lines = source.encode().splitlines(keepends=True)
    line, end = lines[literal.line - 1], literal.column + len(literal.text)
    if line[literal.column : end] != literal.text.encode():
        raise ValueError(f"{literal.key}: expected {literal.text}, found {line[literal.column : end].decode()!r}")
    lines[literal.line - 1] = line[: literal.column] + literal.times(factor).encode() + line[end:]
    return b"".join(lines).decode()


def digest_of(folder: Path) -> str:
    """Digest of the Python files of a folder: results of another text are no results of this one."""
    found = hashlib.sha256()
    for file in sorted(folder.rglob("*.py")):
        found.update(file.relative_to(folder).as_posix().encode() + b"\0" + file.read_bytes())
    return found.hexdigest()[:16]
