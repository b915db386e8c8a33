# SPDX-License-Identifier: Apache-2.0
"""State of Python's imports, for handlers of signals."""

from types import FrameType


def is_importing(frame: FrameType | None) -> bool:
    """Return True during an import: an exception there can leave the lock of all imports locked for ever."""
    while frame is not None:
        if frame.f_code.co_filename.startswith("<frozen importlib"):
            return True
        frame = frame.f_back
    return False
