# SPDX-License-Identifier: Apache-2.0
"""Places where an exception is lost, for handlers of signals that end with one."""

from types import FrameType

_CALLED_BACK = "llvmlite/binding/executionengine.py"
"""Called from C while machine code is made: ctypes prints an exception and goes on."""


def is_unraisable(frame: FrameType | None) -> bool:
    """Return True during an import, a finalizer or a callback of the compiler.

    An exception in an import can leave the lock of all imports locked for ever; the others print it and go on.
    """
    while frame is not None:
        code = frame.f_code
        if code.co_filename.startswith("<frozen importlib") or code.co_filename.endswith(_CALLED_BACK):
            return True
        if code.co_name == "__del__":
            return True
        frame = frame.f_back
    return False
