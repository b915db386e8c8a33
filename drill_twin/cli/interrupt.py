# SPDX-License-Identifier: Apache-2.0
"""SIGINT and SIGTERM in a command: one line and exit code 130 or 143, whenever they come; imports nothing slow.

A command that has something to complete takes them as a request instead (`stop_request`).
"""

import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

from drill_twin.core.process import is_unraisable

_SIGNALS = (signal.SIGINT, signal.SIGTERM)
_STOPPED = b"drill-twin: stopped\n"
_SHOW_CURSOR = b"\r\x1b[2K\x1b[?25h"  # a progress line hides it


class Interrupted(BaseException):
    """Raised by SIGINT or SIGTERM; no KeyboardInterrupt, which the library of the command line handles itself."""

    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.exit_code = 128 + number
        """Exit code of the command: 128 and the number of the signal."""
        self.kept = ""
        """Sentence on what is kept and how to go on."""


def install() -> None:
    """Handle both signals from now on, unless the parent ignores them (`nohup`, a job in the background)."""
    for number in _SIGNALS:
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _on_signal)


def ignore() -> None:
    """Ignore both signals from now on: a second one must not change the exit code of a command that has ended."""
    for number in _SIGNALS:
        signal.signal(number, signal.SIG_IGN)


@contextmanager
def stop_request() -> Iterator[list[int]]:
    """Numbers of the signals that came: empty until one does; a second one ends the command.

    A signal that the parent ignores stays ignored.
    """
    asked: list[int] = []
    before = {number: signal.getsignal(number) for number in _SIGNALS}

    def ask(number: int, frame: object) -> None:
        del frame
        asked.append(number)
        restore()

    def restore() -> None:
        for number, handler in before.items():
            signal.signal(number, handler)

    for number, handler in before.items():
        if handler is not signal.SIG_IGN:
            signal.signal(number, ask)
    try:
        yield asked
    finally:
        restore()


def _on_signal(number: int, frame: FrameType | None) -> None:
    if is_unraisable(frame):
        # a module swallows the exception, or prints it: leave at once, there is nothing to complete
        os.write(2, (_SHOW_CURSOR if os.isatty(2) else b"") + _STOPPED)
        os._exit(128 + number)
    raise Interrupted(number)
