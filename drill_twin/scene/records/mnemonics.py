# SPDX-License-Identifier: Apache-2.0
"""Channels of a record of a rig by the names of their columns, and what stands for no value there."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from drill_twin.core.errors import TableError
from drill_twin.core.rig_channels import RECORDED, RIG_CHANNELS
from drill_twin.core.units import Dimension
from drill_twin.core.units.dimension import TIME


class Channel(NamedTuple):
    """Channel of a record, and the names of its column, those to be preferred first."""

    dimension: Dimension
    mnemonics: tuple[str, ...]
    pattern: str = ""
    """Regular expression of a name that is no known mnemonic, for a set-point whose column the scene does not give."""


_PATTERNS = {
    "time": r"(^|[^a-z])(time|timestamp|stamp|t)([^a-z]|$)",
    "weight_on_bit": r"(^|[^a-z])(wob|weight[ _-]?on[ _-]?bit)([^a-z]|$)",
    "rotation": r"(^|[^a-z])(rpm|rps|top[ _-]?(drive)?[ _-]?(speed|rpm)|rotary[ _-]?speed|rotation)([^a-z]|$)",
}
CHANNELS: Mapping[str, Channel] = {
    "time": Channel(TIME, ("time", "etim", "timestamp_utc_iso", "datetime", "dtim"), _PATTERNS["time"])
} | {
    name: Channel(found.dimension, (*found.mnemonics, found.heading), _PATTERNS.get(name, ""))
    for name, found in ((name, RIG_CHANNELS[field]) for name, field in RECORDED.items())
}
"""Time and the channels of `drill_twin.core.rig_channels` that records have."""


def null_values(given: str, place: str) -> frozenset[float]:
    """Numbers that stand for no value: -999.25, and the one that a file gives.

    Raises:
        TableError: The one given is no number.
    """
    try:
        if not given.isascii() or "_" in given:
            raise ValueError(given)
        return frozenset((-999.25, float(given or -999.25)))
    except ValueError:
        raise TableError(f'{place}: expected a number as null value, found "{given[:40]}"; correct it') from None
