# SPDX-License-Identifier: Apache-2.0
"""Progress of a compilation on standard error, for scripts and notebooks."""

from __future__ import annotations

import sys


class CompileProgress:
    """Writes the progress: on a terminal one line that is written over, else the first text only."""

    def __init__(self) -> None:
        self._width = 0

    def __call__(self, text: str) -> None:
        """Write a text of progress."""
        stream = sys.stderr
        if stream.isatty():
            print(f"\r{text:<{self._width}}", end="", file=stream, flush=True)
        elif self._width == 0:
            print(text, file=stream, flush=True)
        self._width = max(self._width, len(text))

    def end(self) -> None:
        """Erase the line of a terminal."""
        if self._width and sys.stderr.isatty():
            print(f"\r{'':<{self._width}}\r", end="", file=sys.stderr, flush=True)
