# SPDX-License-Identifier: Apache-2.0
"""JSON of unknown origin in bounded time and memory; results that a study writes as it goes, a line of JSON each."""

import json
import logging
import os
import stat
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any, Generic, TypeVar

from pydantic import TypeAdapter

from drill_twin.core.errors import ArgumentError, BagError, DrillTwinError
from drill_twin.core.files.output import writing

LARGEST_TEXT = 1_000_000
"""Bytes or characters of a text."""
ODD_DATA = (LookupError, TypeError, ValueError, AttributeError, OverflowError)
"""Errors of a reader whose data are JSON, but not what the reader expects."""
_RESULTS = "the results", "make room, or choose another folder"
_LONGEST_INTEGER = 300  # digits; a longer integer becomes an infinite float


class JsonError(DrillTwinError, ValueError):
    """A text that is not JSON, or beyond the bounds."""


def read_json(text: str | bytes, *, largest: int = LARGEST_TEXT) -> Any:
    """Plain data of a JSON text; an integer of more than 300 digits is infinite.

    Raises:
        JsonError: Malformed, too long, or too deep.
    """
    if len(text) > largest:
        raise JsonError(f"expected JSON of at most {largest} characters, found {len(text)}")
    try:
        return json.loads(text, parse_int=lambda digits: (int if len(digits) <= _LONGEST_INTEGER else float)(digits))
    except (ValueError, RecursionError) as error:
        raise JsonError(f"expected JSON, found {text[:40]!r}") from error


_LOG = logging.getLogger(__name__)
LONGEST_LINE = 64_000_000
"""Bytes of a line; a longer line counts as a bad line."""
T = TypeVar("T")
_OPEN = os.O_RDWR | os.O_CREAT | os.O_APPEND | os.O_CLOEXEC | os.O_NONBLOCK  # a pipe is refused, not waited for


class JsonLines(Generic[T]):
    """File of results of one setup, to which each result is appended as soon as it is there.

    A result is in the file once `add` returns, so a kill loses only what was being computed. A line that is cut or
    damaged is left out, and its result computed again. Nothing is written to a file that is not of this setup.

    Attributes:
        results: The results, in the order of the file.
        bad: Lines left out.
    """

    def __init__(
        self, file: Path, of: type[T], study: str, setup: Mapping[str, Any], *, remedy: str = "choose another file"
    ) -> None:
        """Open a file, begin it if it is new or empty, and read what it has.

        Args:
            file: The file; neither it nor its folder need exist.
            of: Type of a result, for pydantic: a line with a field that is missing or of another type is a bad line.
            study: Name of what the results are of, which stands in the first line.
            setup: All that the results depend on, in plain types.
            remedy: What to do about a file of another setup, for the error's message.

        Raises:
            ArgumentError: The file is of another setup, or no file of results.
            BagError: The file cannot be read or written, or is no regular file.
        """
        self.file, self.results, self.bad = file, list[T](), 0
        self._type, self._remedy = TypeAdapter(of), remedy
        head = (json.dumps({study: setup}) + "\n").encode()
        with writing(file, *_RESULTS):
            file.parent.mkdir(parents=True, exist_ok=True)
            with os.fdopen(os.open(file, _OPEN, 0o666), "r+b", buffering=0) as stream:
                if not stat.S_ISREG(os.fstat(stream.fileno()).st_mode):
                    raise BagError(f"{file}: expected a regular file, found a pipe or device; choose another file")
                text = stream.read()
                first, newline, rest = text.partition(b"\n")
                if not newline and head.startswith(text):  # new, or broken off in its first line
                    stream.write(head[len(text) :])
                    return
                self._check(first, study, setup)
                stream.truncate(len(first) + 1 + self._read_lines(rest))
            if self.bad:
                lines = "1 line that is no result is" if self.bad == 1 else f"{self.bad} lines that are no results are"
                _LOG.warning("%s: %s left out; what it was of is computed again", file, lines)

    def add(self, result: T) -> None:
        """Append a result: plain types, dataclasses and what has a method `to_dict`.

        Raises:
            BagError: The file cannot be written.
        """
        line = (json.dumps(result, separators=(",", ":"), default=_plain) + "\n").encode()
        with writing(self.file, *_RESULTS), self.file.open("ab", buffering=0) as stream:
            end = stream.tell()
            try:
                while line:
                    line = line[stream.write(line) :]
            except OSError:
                stream.truncate(end)  # no half of a line stays on a full disk
                raise
        self.results.append(result)

    def _read_lines(self, text: bytes) -> int:
        """Read the results; returns the length of the text without a last line that is cut."""
        *lines, cut = text.split(b"\n")
        self.bad = int(cut != b"")
        for line in lines:
            try:
                if len(line) > LONGEST_LINE:
                    raise ValueError("a line that is too long")
                self.results.append(self._type.validate_json(line, strict=True))
            except ODD_DATA:
                self.bad += 1
        return len(text) - len(cut)

    def _check(self, line: bytes, study: str, setup: Mapping[str, Any]) -> None:
        try:
            found = read_json(line, largest=LONGEST_LINE)[study]
            differing = [name for name, value in setup.items() if found.get(name) != json.loads(json.dumps(value))]
        except ODD_DATA:
            raise ArgumentError(
                f"{self.file}: expected results of `{study}`, found another file; {self._remedy}"
            ) from None
        if differing:
            names = " and ".join(differing)
            raise ArgumentError(
                f"{self.file}: expected results of this `{study}`, found results of another {names}; {self._remedy}"
            )


def _plain(result: Any) -> Any:
    return result.to_dict() if hasattr(result, "to_dict") else asdict(result)
