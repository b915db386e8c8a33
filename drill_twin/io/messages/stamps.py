# SPDX-License-Identifier: Apache-2.0
"""Stamps: integer nanoseconds in the package, `builtin_interfaces/Time` (seconds, nanoseconds) in messages."""

import math
import struct
from typing import Any

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.errors import MessageError
from drill_twin.io.messages.type_store import CDR_LITTLE_ENDIAN, message

NANOSECONDS = 1_000_000_000
TIME = struct.Struct("<iI")
"""`builtin_interfaces/Time` in CDR: int32 seconds, uint32 nanoseconds."""

_STAMP_AT = 4  # bytes; the encapsulation comes first
DATED = 10**9 * NANOSECONDS
"""Stamps [ns] from here on, in 2001, are dates: no run is simulated for 31 years."""


def stamp_ns(time: float) -> int:
    """Simulated time [s] as integer nanoseconds, rounded to the nearest.

    Raises:
        MessageError: The time is not a finite number.
    """
    if not math.isfinite(time):
        raise MessageError(f"expected a finite time in seconds for a stamp, found {time}")
    return round(time * NANOSECONDS)


def stamps_ns(times: Array) -> list[int]:
    """Simulated times [s] as integer nanoseconds, each as `stamp_ns`.

    Raises:
        MessageError: A time is not a finite number.
    """
    if not np.isfinite(times).all():
        raise MessageError(f"expected finite times [s] for stamps, found {times[~np.isfinite(times)][0]}")
    return list(map(int, np.rint(times * NANOSECONDS).tolist()))


def seconds(stamp: int) -> float:
    """Stamp [ns] as time [s]."""
    return stamp / NANOSECONDS


def within_range(stamp: int) -> int:
    """The stamp [ns], or the last stamp that a message can hold where the given stamp is later."""
    return min(stamp, 2**31 * NANOSECONDS - 1)


def counted_from(raw: bytes, origin: int) -> bytes:
    """The message with its header stamp counted from a time [ns], of a date; a stamp that is no date stays."""
    stamp = raw_header_stamp(raw)
    if stamp < min(origin, DATED):
        return raw
    counted = bytearray(raw)
    pack_stamp(counted, _STAMP_AT, stamp - origin)
    return bytes(counted)


def pack_stamp(buffer: bytearray, offset: int, stamp: int) -> None:
    """Write a stamp [ns] into CDR bytes.

    Raises:
        MessageError: The stamp does not fit `builtin_interfaces/Time` (0 to 2^31 s).
    """
    try:
        TIME.pack_into(buffer, offset, *divmod(stamp, NANOSECONDS))
    except struct.error as error:
        raise MessageError(
            f"expected a stamp between -2^31 and 2^31 s in integer nanoseconds, found {stamp!r}"
        ) from error


def raw_header_stamp(raw: bytes) -> int:
    """Stamp [ns] at the start of a message, as in a header.

    0 where there are too few bytes, or its numbers are big-endian, which only the general decoder reads.
    """
    if len(raw) < _STAMP_AT + TIME.size or raw[:_STAMP_AT] != CDR_LITTLE_ENDIAN:
        return 0
    whole, part = TIME.unpack_from(raw, _STAMP_AT)
    return int(whole) * NANOSECONDS + int(part)


def time_message(stamp: int) -> Any:
    """`builtin_interfaces/Time` object of a stamp [ns]."""
    whole, part = divmod(stamp, NANOSECONDS)
    return message("builtin_interfaces/msg/Time", sec=whole, nanosec=part)


def header(stamp: int, frame_id: str) -> Any:
    """`std_msgs/Header` object of a stamp [ns] and a frame."""
    return message("std_msgs/msg/Header", stamp=time_message(stamp), frame_id=frame_id)


def header_stamp(content: Any) -> int:
    """Stamp [ns] in the header of a message object."""
    return int(content.header.stamp.sec) * NANOSECONDS + int(content.header.stamp.nanosec)
