# SPDX-License-Identifier: Apache-2.0
"""Standard streams of a process, and the limit of its memory, as the shell left them."""

import os
import resource
import sys
from pathlib import Path

from drill_twin.core.errors import RunError

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


def refuse_too_little_memory() -> None:
    """Refuse a limit of the address space in which the libraries cannot be loaded: they end in various ways then.

    Raises:
        RunError: `ulimit -v` is below what a run needs.
    """
    limit = resource.getrlimit(resource.RLIMIT_AS)[0]
    if limit != resource.RLIM_INFINITY and limit < _NEEDED:
        raise RunError(
            f"expected at least {_NEEDED / 1e6:.0f} MB of address space, found a limit of {limit / 1e6:.0f} MB; "
            "raise it with `ulimit -v`"
        )


def _has_working_folder() -> bool:
    try:
        Path.cwd()
    except OSError:
        return False
    return True


def error_text(error: Exception) -> str:
    """One line for an error of the system that no part of the program has put into words."""
    if isinstance(error, MemoryError):
        return "expected enough memory, found none left; free some, or take fewer elements or a shorter run"
    if not isinstance(error, OSError):
        return str(error)
    if error.filename is None and not _has_working_folder():
        return "expected a working folder, found it removed; change to one that exists"
    names = [str(name) for name in (error.filename, error.filename2) if name is not None]
    place = f"{' and '.join(names)[:200]}: " if names else ""
    return f"{place}{error.strerror or error}; check path, rights and space"
