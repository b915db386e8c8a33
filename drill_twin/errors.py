# SPDX-License-Identifier: Apache-2.0
"""Errors a user can act on: each says what was expected, what was found, where, and what to do."""


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


class CheckpointError(DrillTwinError):
    """A checkpoint that cannot be written, or that a run cannot go on from."""
