# SPDX-License-Identifier: Apache-2.0
"""SIGINT and SIGTERM in a command: one line and exit code 130 or 143, whenever they come; imports nothing slow."""

from __future__ import annotations

import os
import signal
from types import FrameType

from drill_twin.core.process.unraisable import is_unraisable

_SIGNALS = (signal.SIGINT, signal.SIGTERM)
_STOPPED = b"drill-twin: stopped\n"
_SHOW_CURSOR = b"\r\x1b[2K\x1b[?25h"  # a progress line hides it


class Interrupted(BaseException):
    """Raised by SIGINT or SIGTERM; no KeyboardInterrupt, which the library of the command line handles itself."""

    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.exit_code = 128 + number
        """Exit code of the command: 128 and the number of the signal."""


def install() -> None:
    """Handle both signals from now on, unless the parent ignores them (`nohup`, a job in the background)."""
    for number in _SIGNALS:
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _on_signal)


def ignore() -> None:
    """Ignore both signals from now on: a second one must not change the exit code of a command that has ended."""
    for number in _SIGNALS:
        signal.signal(number, signal.SIG_IGN)


def _on_signal(number: int, frame: FrameType | None) -> None:
    if is_unraisable(frame):
        # a module swallows the exception, or prints it: leave at once, there is nothing to complete
        os.write(2, (_SHOW_CURSOR if os.isatty(2) else b"") + _STOPPED)
        os._exit(128 + number)
    raise Interrupted(number)
