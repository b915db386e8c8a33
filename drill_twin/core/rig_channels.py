# SPDX-License-Identifier: Apache-2.0
"""Channels of a rig: one table of their dimensions, their place in `/rig/state`, and their names in records."""

import math
from collections.abc import Mapping
from typing import NamedTuple

from drill_twin.core.units.dimension import ANGLE, ANGULAR_SPEED, FORCE, LENGTH, SPEED, TORQUE, Dimension

RIG_JOINTS = ("top_drive", "bit", "block", "bit_axial")
"""Joints of `/rig/state`; in each, effort times velocity is a power: `bit` turns, `bit_axial` goes down."""
ARRAYS = ("position", "velocity", "effort")
"""Arrays of a JointState."""
INSTANT = "@instant"
"""Ending of a channel's name: its samples are values at an instant, and not means since the last sample."""


class RigChannel(NamedTuple):
    """Quantity of a rig."""

    dimension: Dimension
    array: str
    joint: str
    """Joint of the channel in `/rig/state` and `/measured/rig/state`."""
    heading: str
    """Name in tables and exported files."""
    names: tuple[str, ...] = ()
    """Other names for the channel: of set-points and records first, of the gateway last."""
    mnemonics: tuple[str, ...] = ()
    """Names of the channel's column in a record, in the order of preference; letters and digits, lower case."""
    bounds: tuple[float, float] = (-math.inf, math.inf)
    """Least and largest value that a rig can have, far from any rig of today, SI; beyond, no value was measured."""


RIG_CHANNELS: Mapping[str, RigChannel] = {
    "bit_force": RigChannel(
        FORCE, "effort", "bit_axial", "weight on bit", ("weight_on_bit",),
        ("wob", "swob", "woba", "wobavg", "weightonbit", "bitweight", "wtonbit"), (-2e6, 2e6),
    ),
    "top_drive_speed": RigChannel(
        ANGULAR_SPEED, "velocity", "top_drive", "speed of the top drive", ("rotation", "surface_rotation"),
        ("rpm", "rpma", "srpm", "surfrpm", "tdrpm", "rpmavg", "surfacerpm", "topdriverpm", "topdrivespeed", "tdspeed",
         "rotaryrpm", "rotaryspeed", "rpmsurface", "rotation", "rotarytablespeed"), (-1000.0, 1000.0),
    ),
    "top_drive_torque": RigChannel(
        TORQUE, "effort", "top_drive", "torque of the top drive on the string",
        ("torque", "motor_torque", "surface_torque"),
        ("tqa", "torque", "stor", "trq", "tq", "tdtq", "torqueavg", "surfacetorque", "torq", "tor",
         "topdrivetorque", "tdtorque", "rotarytorque", "convertibletorque", "surftorque"), (-5e5, 5e5),
    ),
    "hookload": RigChannel(
        FORCE, "effort", "block", "hookload", (),
        ("hkld", "hkla", "hookload", "hkldavg", "hook", "hkl", "totalhookload", "hookloadtotal"),
        (-2e6, 2e7),
    ),
    "bit_speed": RigChannel(
        ANGULAR_SPEED, "velocity", "bit", "speed of the bit", ("bit_speed", "bit_rotation"),
        ("brpm", "drpm", "dhrpm", "bitrpm", "bitrpmavg", "downholerpm", "bitspeed"), (-1000.0, 1000.0),
    ),
    "bit_torque": RigChannel(
        TORQUE, "effort", "bit", "torque of the rock on the bit", (),
        ("btq", "dtor", "dhtq", "downholetorque", "bittorque"), (-5e5, 5e5),
    ),
    "block_position": RigChannel(
        LENGTH, "position", "block", "height of the travelling block above its start", (),
        ("bpos", "blkpos", "blockposition", "hookposition", "blockheight", "travellingblockposition"), (-500.0, 500.0),
    ),
    "block_velocity": RigChannel(SPEED, "velocity", "block", "velocity of the travelling block, positive up"),
    "top_drive_angle": RigChannel(ANGLE, "position", "top_drive", "angle of the top drive"),
    "bit_angle": RigChannel(ANGLE, "position", "bit", "angle of the bit"),
    "drilled": RigChannel(LENGTH, "position", "bit_axial", "depth drilled"),
    "rate_of_penetration": RigChannel(SPEED, "velocity", "bit_axial", "rate of penetration"),
}  # fmt: skip
"""Channels by their field of `RigState`.

Mnemonics are the short mnemonics of WITS level 0 (record 1), the usual mnemonics of LAS and WITSML, the names of D-WIS,
the columns of Drillbotics, and the headings of the exports of Pason, Totco and NOV and of the field data of Volve. The
heading is a mnemonic too, so that exported files can be read.
"""

RECORDED: Mapping[str, str] = {
    (channel.names or (field,))[0]: field for field, channel in RIG_CHANNELS.items() if channel.mnemonics
}
"""Name of each channel of a record, and its field of `RigState`."""


FIELDS: Mapping[str, str] = {name: field for field, channel in RIG_CHANNELS.items() for name in (*channel.names, field)}
"""Field of `RigState` of a channel, by each of its names."""


def channel_of(name: str) -> RigChannel:
    """Channel by any of its names.

    Raises:
        KeyError: There is no such channel.
    """
    return RIG_CHANNELS[FIELDS[name]]
