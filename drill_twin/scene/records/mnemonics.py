# SPDX-License-Identifier: Apache-2.0
"""Names of columns and units in records of rigs, of WITS, WITSML, LAS and Drillbotics -> those of this package."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from drill_twin.core.errors import TableError
from drill_twin.core.units import Dimension, UnitError, factor_of
from drill_twin.core.units.dimension import ANGULAR_SPEED, FORCE, LENGTH, TIME, TORQUE


class Channel(NamedTuple):
    """Quantity of a rig, and the names of its column, those to be preferred first."""

    dimension: Dimension
    mnemonics: tuple[str, ...]


CHANNELS: Mapping[str, Channel] = {
    "time": Channel(TIME, ("time", "etim", "timestamp_utc_iso", "datetime", "dtim")),
    "weight_on_bit": Channel(FORCE, ("wob", "swob", "woba", "wob_avg", "wob_kn", "weight on bit")),
    "rotation": Channel(
        ANGULAR_SPEED,
        ("rpm", "rpma", "srpm", "surf_rpm", "tdrpm", "rpm_avg", "surfacerpm", "speed of the top drive"),
    ),
    "torque": Channel(
        TORQUE,
        ("tqa", "torque", "stor", "trq", "tq", "tdtq", "torque_avg", "torque_knm", "surfacetorque",
         "torque of the top drive on the string"),
    ),
    "hookload": Channel(FORCE, ("hkld", "hkla", "hookload", "hkld_avg", "hookload_kn")),
    "bit_speed": Channel(
        ANGULAR_SPEED,
        ("brpm", "drpm", "dhrpm", "bit_rpm", "bit_rpm_avg", "downholerpm", "speed of the bit"),
    ),
    "bit_torque": Channel(TORQUE, ("btq", "dtor", "dhtq", "downholetorque", "torque of the rock on the bit")),
    "block_position": Channel(
        LENGTH, ("bpos", "blkpos", "block_position", "hookposition", "height of the travelling block above its start")
    ),
}  # fmt: skip
"""Channels, with the short mnemonics of WITS level 0 (record 1), those usual in LAS and WITSML, the names of D-WIS, the
columns of Drillbotics and the headings of `drill-twin export`; lower case."""

_UNITS: Mapping[str, tuple[str, float]] = {
    "knm": ("kN m", 1.0),
    "nm": ("N m", 1.0),
    "danm": ("daN m", 1.0),
    "kdanm": ("daN m", 1000.0),
    "ftlb": ("ft lbf", 1.0),
    "ftlbs": ("ft lbf", 1.0),
    "ftlbf": ("ft lbf", 1.0),
    "lbfft": ("ft lbf", 1.0),
    "kftlb": ("ft lbf", 1000.0),
    "kftlbf": ("ft lbf", 1000.0),
    "klbfft": ("ft lbf", 1000.0),
    "kn": ("kN", 1.0),
    "n": ("N", 1.0),
    "dan": ("daN", 1.0),
    "kdan": ("daN", 1000.0),
    "kgf": ("kgf", 1.0),
    "kkgf": ("kgf", 1000.0),
    "t": ("tf", 1.0),
    "tf": ("tf", 1.0),
    "tonf": ("tf", 1.0),
    "lb": ("lbf", 1.0),
    "lbs": ("lbf", 1.0),
    "lbf": ("lbf", 1.0),
    "klb": ("klbf", 1.0),
    "klbs": ("klbf", 1.0),
    "klbf": ("klbf", 1.0),
    "1000lbf": ("klbf", 1.0),
    "rpm": ("rpm", 1.0),
    "1/min": ("rpm", 1.0),
    "c/min": ("rpm", 1.0),
    "rev/min": ("rpm", 1.0),
    "c/s": ("rev/s", 1.0),
    "rps": ("rev/s", 1.0),
    "rad/s": ("rad/s", 1.0),
    "m": ("m", 1.0),
    "ft": ("ft", 1.0),
    "f": ("ft", 1.0),
    "s": ("s", 1.0),
    "sec": ("s", 1.0),
    "min": ("min", 1.0),
    "h": ("h", 1.0),
    "hr": ("h", 1.0),
    "d": ("h", 24.0),
}
"""Spellings of units in records, lower case and without the sign of a product -> unit of this package, how many."""
_PRODUCT = str.maketrans("", "", " .*·-")


def si_factor(unit: str, dimension: Dimension) -> float:
    """SI factor of a unit in a record: as this package writes it, else by the table of spellings.

    Raises:
        UnitError: It is none of the dimension.
    """
    try:
        return factor_of(unit, dimension)
    except UnitError:
        known, count = _UNITS.get(unit.lower().translate(_PRODUCT), ("", 0.0))
        if not known:
            raise
        return count * factor_of(known, dimension)


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
