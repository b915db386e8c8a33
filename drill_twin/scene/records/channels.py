# SPDX-License-Identifier: Apache-2.0
"""Channels of a rig's record: the names of their columns, and how a user names one."""

import math
import re
from collections.abc import Callable, Mapping
from typing import NamedTuple

from drill_twin.core import numerals
from drill_twin.core.errors import ArgumentError, TableError, nearest
from drill_twin.core.rig_channels import FIELDS, INSTANT, RECORDED, RIG_CHANNELS
from drill_twin.core.units import Dimension
from drill_twin.core.units.dimension import TIME


class RecordChannel(NamedTuple):
    """Channel of a record, and the names of its column in the order of preference."""

    dimension: Dimension
    mnemonics: tuple[str, ...]


def plain(name: str) -> str:
    """Letters and digits of a name, lower case."""
    return re.sub(r"[\W_]+", "", name.lower())


CHANNELS: Mapping[str, RecordChannel] = {
    "time": RecordChannel(
        TIME,
        ("time", "etim", "timestamputciso", "datetime", "dtim", "timestamp", "rigtime", "elapsedtime", "date", "t",
         "epoch", "unixtime", "timedate", "utc", "localtime"),
    )
} | {
    name: RecordChannel(channel.dimension, (*channel.mnemonics, plain(channel.heading)))
    for name, channel in ((name, RIG_CHANNELS[field]) for name, field in RECORDED.items())
}  # fmt: skip
"""Time and the channels of `drill_twin.core.rig_channels` that records have."""
NULL, BLOCK = "null_value", "block_weight"
"""Names that give a number in place of a column: `null_value: -5555`, and `block_weight: 32 klbf`, in the hookload."""


def null_values(given: str, place: str) -> tuple[float, ...]:
    """The null value of a file or an option, if it is a number at all.

    Raises:
        TableError: The text is no number.
    """
    null = math.nan if given.lower() in {"", "nan"} else numerals.number(given)
    if null is None:
        raise TableError(f'{place}: expected a number as null value, found "{given[:40]}"; correct it')
    return () if math.isnan(null) else (null,)


class ChannelColumn(NamedTuple):
    """Column of a record; the name of a channel ends with `@instant` if its samples are no means."""

    channel: str
    column: str
    """Name of the column; empty: the column that has a known mnemonic of the channel."""
    unit: str
    """Unit of the column, of dates their form; empty: the unit that the file gives."""


def channel_column(text: str, is_name: Callable[[str], bool] = lambda _: False) -> ChannelColumn:
    """Parse `CHANNEL=COLUMN:UNIT`, `CHANNEL=COLUMN` where the file gives the unit, or `CHANNEL` for a known mnemonic.

    `CHANNEL@instant` is a channel whose samples are values at their times, and not means since the last ones.

    Args:
        text: The text.
        is_name: Tells a name of a column, which may have a colon.

    Raises:
        ArgumentError: An unknown channel.
    """
    channel, _, rest = (part.strip() for part in text.partition("="))
    known = [
        *dict.fromkeys(
            (*CHANNELS, *(name for name, field in FIELDS.items() if field in RECORDED.values()), NULL, BLOCK)
        )
    ]
    if channel.removesuffix(INSTANT) not in known:
        raise ArgumentError(
            f'channel: expected NAME=COLUMN:UNIT with one of {", ".join(known)}, found "{text}"'
            + nearest(channel, known)
        )
    places = [at for at, letter in enumerate(rest) if letter == ":" and is_name(rest[:at].strip())]
    if places and not is_name(rest):  # a form of dates has colons too
        return ChannelColumn(channel, rest[: places[0]].strip(), rest[places[0] + 1 :].strip())
    column, colon, unit = rest.rpartition(":")
    return ChannelColumn(channel, column, unit) if colon and not is_name(rest) else ChannelColumn(channel, rest, "")


def recorded(channel: str) -> str:
    """Name of a channel in records, of any of its names."""
    field = FIELDS.get(channel, "")
    return next((name for name, one in RECORDED.items() if one == field), channel)
