# SPDX-License-Identifier: Apache-2.0
"""Errors for the user: each message names place, expected, found and remedy; text of unknown origin is escaped.

Packages that come with an extra of drill_twin are imported here, with an error that names the extra.
"""

import difflib
import re
from collections.abc import Iterable
from importlib import import_module
from typing import Any, Self


def printable(text: str, *, keep: str = "\n") -> str:
    r"""Text in which each control character, format character (bidirectional marks) or surrogate is written out.

    ESC becomes `\x1b`, U+202E `\u202e`: a name in a bag cannot move the cursor, change the title of a window, or
    reverse the order of what follows.

    Args:
        text: The text.
        keep: Characters that stay although they are not printable.
    """
    if text.isprintable():
        return text
    return "".join(
        letter if letter.isprintable() or letter in keep else letter.encode("unicode_escape").decode("ascii")
        for letter in text
    )


def shortened(text: str, longest: int = 300) -> str:
    """Text of a stranger fit for a log or an answer: printable, on one line, at most `longest` characters."""
    text = printable(text[: 2 * longest], keep="")
    return text if len(text) <= longest else f"{text[:longest]}..."


def encoding_problem(error: UnicodeDecodeError) -> str:
    """Words for a text that is not UTF-8: the encoding that it seems to have, and what to do."""
    begin = bytes(error.object[:2])
    found = "UTF-16" if begin in {b"\xff\xfe", b"\xfe\xff"} else "another encoding, such as Latin-1 or Windows-1252"
    return f"{found} (byte {error.object[error.start]:#04x}); save it as UTF-8"


def nearest(name: str, known: Iterable[str], likeness: float = 0.6) -> str:
    """Suggestion such as `, did you mean "radius"?` if one of the known names is close, else an empty text.

    Args:
        name: The name that is not known.
        known: Known names.
        likeness: Least likeness of a close name, as `difflib` measures it, 0 to 1.
    """
    folded = {word.lower(): word for word in known}
    close = difflib.get_close_matches(name.lower(), folded, n=1, cutoff=likeness)
    return f', did you mean "{folded[close[0]]}"?' if close else ""


def words_cut(text: str) -> str:
    """Text in which each word of more than 200 characters, such as an absurd path, has its ends only."""
    return re.sub(r"\S{201,}", lambda word: f"{word[0][:80]}...{word[0][-80:]}", text)


class DrillTwinError(Exception):
    """Base of all errors that the user can correct; the command line prints it on one line."""

    exit_code = 2
    """Exit code of a command that ends with this error: 2 for an input, 1 for a run that stopped."""

    def __init__(self, message: str = "") -> None:
        super().__init__(printable(words_cut(message)))


class SceneError(DrillTwinError):
    """A scene file that cannot be simulated as written; the message has its first problem.

    Attributes:
        problems: All problems of a scene, one line each, in the order of the file; empty for other errors.
    """

    problems: tuple[str, ...] = ()


class TableError(DrillTwinError):
    """A table of measured set-points that cannot be used."""


class BagError(DrillTwinError):
    """A bag that cannot be written, read or analysed."""


class MessageError(DrillTwinError):
    """Bytes or values that are no message of the topic contract; what was found is cut short."""

    def __init__(self, message: str = "") -> None:
        super().__init__(shortened(message, 500))


class NotFiniteError(MessageError):
    """A result that is no finite number, and so is not sent: the run ends."""

    exit_code = 1


class RunError(DrillTwinError):
    """A run that cannot continue; the message names time, place and likely remedy."""


class RunStopped(BaseException):
    """A request to stop in the middle of a frame; the twin is back at the end of the last whole one."""


class StoppedError(RunError):
    """A run stopped by the step guard after several retries; the twin is back at the last good frame.

    Attributes:
        time: Simulated time of that frame [s].
        kind: Kind of the violation (`drill_twin.dynamics.twin.step_guard.Violation`).
        node: Node at which the violation was largest.
        effect: Key of the effect that caused the violation; empty if none was identified.
    """

    exit_code = 1

    def __init__(self, message: str, time: float, kind: str, node: int, effect: str) -> None:
        super().__init__(message)
        self.time, self.kind, self.node, self.effect = time, kind, node, effect

    def with_message(self, message: str) -> Self:
        """Copy with another message."""
        return type(self)(message, self.time, self.kind, self.node, self.effect)

    def __reduce__(self) -> tuple[type[Self], tuple[str, float, str, int, str]]:
        """Support pickling, for transfer between processes."""
        return type(self), (str(self), self.time, self.kind, self.node, self.effect)


class ArgumentError(DrillTwinError, ValueError):
    """An argument of a function of the Python API that cannot be used."""


class ParameterError(DrillTwinError):
    """A node parameter with which a node cannot start."""


class CheckpointError(DrillTwinError):
    """A checkpoint that cannot be written, read or resumed."""


_EXTRAS = {"xarray": ("xarray", "to_xarray"), "lasio": ("las", "LAS file"), "distributed": ("dask", "--dask"),
           "pandas": ("xarray", "to_pandas"), "arviz_base": ("arviz", "to_inferencedata"),
           "rerun": ("rerun", "--rerun")}  # fmt: skip
"""Package -> its extra, and what it is for."""


def import_extra(package: str) -> Any:
    """Import a package.

    Args:
        package: Name of its module: `xarray`, `pandas`, `lasio`, `distributed`, `arviz_base` or `rerun`.

    Raises:
        ArgumentError: The package is not installed.
    """
    extra, purpose = _EXTRAS[package]
    try:
        return import_module(package)
    except ImportError:
        raise ArgumentError(
            f"{purpose}: expected the package {package}, found none; install it: pip install 'drill_twin[{extra}]'"
        ) from None


def missing(error: ModuleNotFoundError, extra: str) -> DrillTwinError:
    """Error of a part of drill_twin whose extra is not installed, from the failed import."""
    module = (error.name or "").partition(".")[0]  # a part of the package may be what was asked for first
    return DrillTwinError(f"expected the Python module {module!r}, found none; pip install 'drill_twin[{extra}]'")
