# SPDX-License-Identifier: Apache-2.0
"""Record of a rig as a bag: its channels as messages on `/rig/state`."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from drill_twin.errors import TableError
from drill_twin.io.bag.memory import MemoryBag
from drill_twin.io.messages.cdr import JointStateTemplate
from drill_twin.io.messages.rig_messages import RIG_JOINTS
from drill_twin.io.messages.stamps import NANOSECONDS
from drill_twin.io.messages.topics import RIG_STATE
from drill_twin.schedule.reading import CHANNELS, RECORDS, read_columns

_SPEEDS = ("rotation", "bit_speed")
_LATEST = 2.0**31  # s, of a stamp


def is_record(path: Path) -> bool:
    """True for a file with the ending of a CSV, MAT, LAS or WITSML record."""
    return path.suffix.lower() in RECORDS and not path.is_dir()


class RecordBag(MemoryBag):
    """Bag in memory with the channels of a record; those that it lacks are NaN.

    Attributes:
        read: The columns that were read and their units, for the user.
    """

    def __init__(self, path: Path) -> None:
        """Read a record; columns are found by their mnemonics.

        Raises:
            TableError: It cannot be read, or has no time or no speed.
            ArgumentError: A LAS file, and the package lasio is not installed.
        """
        super().__init__(str(path))
        columns = read_columns(path)
        values, told = {}, []
        for name, channel in CHANNELS.items():
            found = columns.named(name)
            unit = columns.unit(found[0], channel.dimension) if found else ""
            if len(found) == 1 and unit:
                values[name] = columns.si(found[0], unit, channel.dimension, name)
                told.append(f"{name} from {found[0].partition('[')[0].strip()} [{unit}]")
        if "time" not in values or not any(name in values for name in _SPEEDS):
            known = "; ".join(f"{name}: {', '.join(CHANNELS[name].mnemonics)}" for name in ("time", *_SPEEDS))
            raise TableError(
                f"{path}: expected columns of time and of the speed of top drive or bit with their units, found "
                f"{columns.listed}; known names: {known}"
            )
        self.read = f"{path.name}: {', '.join(told)}; converted to SI"
        time = values["time"]
        if not np.nanmin(time, initial=0.0) >= 0.0:
            raise TableError(f"{path}: expected times from 0 s, found {np.nanmin(time):g} s; shift them")
        if not np.nanmax(time, initial=0.0) < _LATEST:
            raise TableError(f"{path}: expected times of at most {_LATEST:g} s, found {np.nanmax(time):g} s")
        empty, template = np.full(time.size, math.nan), JointStateTemplate(RIG_JOINTS)
        position, velocity, effort = (
            np.column_stack([values.get(name, empty) for name in names])
            for names in (
                ("", "", "block_position", ""),
                ("rotation", "bit_speed", "", ""),
                ("torque", "weight_on_bit", "hookload", "bit_torque"),
            )
        )
        for k in np.flatnonzero(np.isfinite(time)):
            stamp = round(time[k] * NANOSECONDS)
            self.write(RIG_STATE, stamp, template.fill(stamp, position[k], velocity[k], effort[k]))
