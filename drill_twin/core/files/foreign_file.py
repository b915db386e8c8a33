# SPDX-License-Identifier: Apache-2.0
"""Files of unknown origin: opened if regular and not too large, read as bytes, as a text or line by line."""

import codecs
import io
import os
import stat
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from drill_twin.core.errors import DrillTwinError, encoding_problem

LONGEST_LINE = 1_000_000
"""Characters of a line."""
_LONGEST_PATH = 200  # characters, in a message
_OTHERS = "drill_twin_latin_1"


def _as_latin_1(error: UnicodeError) -> tuple[str, int]:
    """Handler of bytes that are not UTF-8: each is its character of Latin-1."""
    if not isinstance(error, UnicodeDecodeError):
        raise error
    return error.object[error.start : error.end].decode("latin-1"), error.end


codecs.register_error(_OTHERS, _as_latin_1)


@dataclass(frozen=True)
class ForeignFile:
    """Kind of file, its bounds, and the error that refuses another."""

    what: str
    """Name of what is expected, for messages: `a CSV table`."""
    largest: int
    """Bytes of a file."""
    error: type[DrillTwinError]
    may_be_empty: bool = True

    def open(self, path: str | Path) -> BinaryIO:
        """Open a file; a pipe or a device, which may have no beginning or no end, is refused and not waited for.

        Raises:
            DrillTwinError: Of the type `error`: no such file, or the file is not regular, too large or not readable.
        """
        try:
            stream = os.fdopen(os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC), "rb")
        except FileNotFoundError:
            raise self.refused(path, "nothing there; check the path") from None
        except IsADirectoryError:
            raise self.refused(path, "a folder") from None
        except (OSError, ValueError) as error:  # a socket, a loop of links, NUL in the name
            raise self.refused(path, getattr(error, "strerror", None) or str(error)) from None
        status = os.fstat(stream.fileno())
        found = expected = ""
        if not stat.S_ISREG(status.st_mode):
            found = "a pipe or a device; write it to a file, and name that"
        elif status.st_size > self.largest:
            found, expected = str(status.st_size), f"of at most {self.largest} bytes"
        elif not status.st_size and not self.may_be_empty:
            found = "an empty one; export it again"
        if found:
            stream.close()
            raise self.refused(path, found, expected)
        return stream

    def read(self, path: str | Path) -> bytes:
        """Read the whole content.

        Raises:
            DrillTwinError: As `open`.
        """
        try:
            with self.open(path) as stream:
                return stream.read(self.largest)  # it may have grown
        except OSError as error:
            raise self.refused(path, error.strerror or str(error)) from None

    def text(self, path: str | Path) -> str:
        """Read a text in UTF-8, with or without a byte order mark.

        Raises:
            DrillTwinError: As `open`, or the file is no such text.
        """
        try:
            return self.read(path).decode("utf-8-sig")
        except UnicodeDecodeError as error:
            raise self.refused(path, encoding_problem(error), "in UTF-8") from None

    def lines(self, path: str | Path, *, longest: int = LONGEST_LINE, latin: bool = False) -> Iterator[tuple[int, str]]:
        """Read a text in UTF-8 line by line: its number, from 1, and text; an endless one is not read.

        Args:
            path: The file.
            longest: Characters of a line.
            latin: Read bytes that are not UTF-8 as Latin-1, and UTF-16 that begins with its mark.

        Raises:
            DrillTwinError: As `text`, or the file has a line that is too long, or binary data.
        """
        number = 0
        try:
            with self.open(path) as stream:
                encoding = "utf-16" if stream.read(2) in {b"\xff\xfe", b"\xfe\xff"} else "utf-8-sig"
                if encoding == "utf-16" and not latin:
                    raise self.refused(path, "UTF-16; save it as UTF-8", "in UTF-8")
                stream.seek(0)
                text = io.TextIOWrapper(stream, encoding, _OTHERS if latin and encoding != "utf-16" else "strict")
                while line := text.readline(longest + 1):
                    number += 1
                    if len(line) > longest:
                        raise self.error(
                            f"{path}:{number}: expected a line of at most {longest} characters, found more"
                        )
                    if "\0" in line:
                        raise self.refused(f"{path}:{number}", "binary data")
                    yield number, line
        except UnicodeDecodeError as error:
            raise self.refused(path, encoding_problem(error), "in UTF-8") from None
        except OSError as error:
            raise self.refused(path, error.strerror or str(error)) from None

    def refused(self, path: str | Path, found: str, expected: str = "") -> DrillTwinError:
        """The error for a file: what was expected and found there."""
        return self.error(f"{str(path)[:_LONGEST_PATH]}: expected {f'{self.what} {expected}'.strip()}, found {found}")
