# SPDX-License-Identifier: Apache-2.0
"""Channels of the rig over time as CSV and as LAS 2.0, in the units of a rig's own records."""

import io
import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from drill_twin.core import __version__
from drill_twin.core.arrays import Array
from drill_twin.core.errors import BagError, MessageError, import_extra
from drill_twin.core.rig_channels import RIG_CHANNELS
from drill_twin.core.table import Column, Table
from drill_twin.core.units.dimension import ANGULAR_SPEED, FORCE, LENGTH, TORQUE
from drill_twin.io.bag.series import RigSeries
from drill_twin.io.bag.skipped import SkippedMessages
from drill_twin.io.messages.decode import read_string
from drill_twin.io.messages.topics import RIG_STATE, TWIN_SCENE
from drill_twin.report.run_log import scene_content
from drill_twin.report.selection import SelectedMessages, Selection, open_bag

_COLUMNS = (
    "bit_force", "hookload", "top_drive_speed", "top_drive_torque", "bit_speed", "bit_torque", "block_position",
)  # fmt: skip
_UNITS = {
    FORCE: ("kN", 1e-3), TORQUE: ("kN.m", 1e-3), ANGULAR_SPEED: ("rpm", 30.0 / math.pi), LENGTH: ("m", 1.0),
}  # fmt: skip
"""Unit of a column by its dimension, and how many of the unit make one SI unit."""
NULL = -999.25
"""Value of LAS for none."""


@dataclass(frozen=True, eq=False)
class Channel:
    """Samples of a channel, shape (T,)."""

    mnemonic: str
    name: str
    unit: str
    values: Array


def read_rig(path: str | Path, selection: Selection) -> tuple[RigSeries, str]:
    """States of the rig in a part of a bag, of its last run, and the name of the scene; nothing is analysed.

    Raises:
        BagError: The path is no bag, or the bag has no such states in this time.
        TableError: The path is a record that cannot be read.
    """
    bag = open_bag(path, selection)
    rig, scene = RigSeries(), ""
    for topic, raw, _ in SelectedMessages(bag, selection, set()).read((TWIN_SCENE, RIG_STATE), SkippedMessages()):
        if topic == RIG_STATE:
            with suppress(MessageError):
                rig.add_message(raw)
            continue
        if scene not in {"", text := read_string(raw)}:
            rig = RigSeries()
        scene = text
    if not len(rig):
        raise BagError(
            f"{path}: expected messages on {RIG_STATE} in this time, found none; choose another --from, --to"
        )
    return rig, str(scene_content(scene).get("name") or "")


def rig_channels(rig: RigSeries) -> list[Channel]:
    """Channels of `/rig/state`, converted: N to kN, N m to kN.m, rad/s to rpm; the first is the time [s]."""
    columns = [Channel("TIME", "time", "s", rig.time)]
    for field in _COLUMNS:
        channel = RIG_CHANNELS[field]
        unit, count = _UNITS[channel.dimension]
        columns.append(Channel(channel.mnemonics[0].upper(), channel.heading, unit, count * getattr(rig, field)))
    return columns


def csv_text(channels: Sequence[Channel]) -> str:
    """A header of names and units, a line a sample; empty where a channel has none."""
    rows = zip(*(channel.values.tolist() for channel in channels), strict=True)
    shown = ([f"{value:.10g}" if math.isfinite(value) else "" for value in row] for row in rows)
    return Table([Column(channel.name, channel.unit) for channel in channels], shown).csv()


def las_text(channels: Sequence[Channel], well: str) -> str:
    """LAS 2.0 (Canadian Well Logging Society 1992) over time.

    Raises:
        ArgumentError: The package lasio is not installed.
    """
    las = import_extra("lasio").LASFile()
    las.well["WELL"].value = well
    las.well["COMP"].value = f"drill_twin {__version__}, simulated"
    las.well["NULL"].value = NULL
    for channel in channels:
        las.append_curve(channel.mnemonic, channel.values, unit=channel.unit, descr=channel.name)
    for item in ("STRT", "STOP", "STEP"):
        las.well[item].descr = las.well[item].descr.replace("DEPTH", "TIME")
    text = io.StringIO()
    las.write(text, version=2.0, fmt="%.10g", len_numeric_field=18)
    return text.getvalue()
