# SPDX-License-Identifier: Apache-2.0
"""The process itself: environment of children, standard streams, lost exceptions."""

import os
import resource
import sys
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from types import FrameType
from typing import NoReturn

from drill_twin.core.errors import RunError

_CALLED_BACK = "llvmlite/binding/executionengine.py"
"""Called from C while machine code is made: ctypes prints an exception and goes on."""


def is_unraisable(frame: FrameType | None) -> bool:
    """Return True during an import, a finalizer or a callback of the compiler.

    An exception in an import can leave the lock of all imports locked for ever. A finalizer or a callback prints the
    exception and goes on.
    """
    while frame is not None:
        code = frame.f_code
        if code.co_filename.startswith("<frozen importlib") or code.co_filename.endswith(_CALLED_BACK):
            return True
        if code.co_name == "__del__":
            return True
        frame = frame.f_back
    return False


_ROOT = Path(__file__).resolve().parents[2]
_SITE = {"site-packages", "dist-packages"}


def child_environment(environment: Mapping[str, str] | None = None) -> dict[str, str]:
    """Environment for a child, by default made from the environment of this process.

    `python -c` and `python -m` import from the working folder first, and so does a relative or an empty entry of
    PYTHONPATH: a `numpy.py` beside a recording would be run. Such imports are turned off, and the child imports
    this copy of the package.
    """
    given = dict(os.environ if environment is None else environment)
    entries = [entry for entry in given.get("PYTHONPATH", "").split(os.pathsep) if Path(entry).is_absolute()]
    own = [] if _SITE.intersection(_ROOT.parts) or str(_ROOT) in entries else [str(_ROOT)]
    return given | {"PYTHONSAFEPATH": "1", "PYTHONPATH": os.pathsep.join([*own, *entries])}


_NEEDED = 1_000_000_000
"""Address space [bytes] below which a run is refused; with all libraries loaded a run takes 0.6 GB, a report more."""


def open_closed_streams() -> None:
    """Open /dev/null in place of standard streams that the shell has closed (`>&-`).

    Otherwise the next file that is opened, such as a bag, gets the number of stdout, and what is printed goes there.
    """
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # the lowest free number, which is this one
    for name, number in (("stdout", 1), ("stderr", 2)):
        if getattr(sys, name) is None:
            setattr(sys, name, os.fdopen(number, "w", closefd=False))


def use_one_thread_of_blas() -> None:
    """Ask BLAS for one thread, unless the user has asked for a number; to be called before numpy is imported.

    The matrices here are small: on a busy machine its threads wait for each other a thousand times as long as they
    compute, and the analyzer would stand still.
    """
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


def refuse_too_little_memory() -> None:
    """Refuse a limit of the address space in which loading the libraries would end the process in various ways.

    Raises:
        RunError: `ulimit -v` is below what a run needs.
    """
    limit = resource.getrlimit(resource.RLIMIT_AS)[0]
    if limit != resource.RLIM_INFINITY and limit < _NEEDED:
        raise RunError(
            f"expected at least {_NEEDED / 1e6:.0f} MB of address space, found a limit of {limit / 1e6:.0f} MB; "
            "raise it with `ulimit -v`"
        )


def error_text(error: Exception) -> str:
    """One line for an error of the system that no part of the program has put into words."""
    if isinstance(error, MemoryError):
        return "expected enough memory, found none left; free some, or take fewer elements or a shorter run"
    if not isinstance(error, OSError):
        return str(error)
    if error.filename is None:
        try:
            Path.cwd()
        except OSError:
            return "expected a working folder, found it removed; change to a folder that exists"
    names = [str(name) for name in (error.filename, error.filename2) if name is not None]
    place = f"{' and '.join(names)[:200]}: " if names else ""
    return f"{place}{error.strerror or error}; check path, rights and space"


def end_process(code: int) -> NoReturn:
    """End the process with an exit code, after all has been closed.

    Where rclpy is loaded, without Python's own end: what is left of its EventsExecutor (7.1.6) now and then crashes
    in it.
    """
    if "rclpy" not in sys.modules:
        sys.exit(code)
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError, ValueError):  # closed, or its reader is gone
            stream.flush()
    os._exit(code)
