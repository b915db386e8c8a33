# SPDX-License-Identifier: Apache-2.0
"""Errors a user can act on: each says what was expected, what was found, where, and what to do."""

from typing import Self


class DrillTwinError(Exception):
    """Base of every error that is the user's to mend; the command line prints it as one line."""


class SceneError(DrillTwinError):
    """A scene file that cannot be simulated as written."""


class TableError(DrillTwinError):
    """A table of measured set-points that cannot be played back."""


class BagError(DrillTwinError):
    """A bag that cannot be written, read or analysed."""


class MessageError(DrillTwinError):
    """Bytes or values that do not make a message of the topic contract."""


class RunError(DrillTwinError):
    """A run that could not go on: names the time, the place and the likely remedy."""


class StoppedError(RunError):
    """The guard stopped a run after several tries; the twin is back at the last good frame.

    Attributes:
        time: Simulated time of that frame [s].
        kind: What was violated (`drill_twin.twin.frame.Intervention`).
        node: Where it was worst.
        effect: Key of the effect behind it; empty where none could be named.
    """

    def __init__(self, message: str, time: float, kind: str, node: int, effect: str) -> None:
        super().__init__(message)
        self.time, self.kind, self.node, self.effect = time, kind, node, effect

    def saying(self, message: str) -> Self:
        """The same with another text."""
        return type(self)(message, self.time, self.kind, self.node, self.effect)

    def __reduce__(self) -> tuple[type[Self], tuple[str, float, str, int, str]]:
        """So that it gets from one process to another."""
        return type(self), (str(self), self.time, self.kind, self.node, self.effect)


class CheckpointError(DrillTwinError):
    """A checkpoint that cannot be written, or that a run cannot go on from."""
