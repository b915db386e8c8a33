# SPDX-License-Identifier: Apache-2.0
"""Message definitions, type hashes and plain CDR for ROS 2 Jazzy, from rosbags' type store.

This is the slow, general way in and out of CDR (10 to 1000 us a message); `cdr` holds the fast one.
"""

from __future__ import annotations

from functools import cache
from typing import Any

from rosbags.serde import SerdeError
from rosbags.typesys import Stores, get_typestore
from rosbags.typesys.store import Typestore

from drill_twin.errors import MessageError

CDR_LITTLE_ENDIAN = b"\x00\x01\x00\x00"
"""The four bytes ahead of every message; alignment counts from behind them."""

SPARE_BYTES = 16
"""Most bytes behind the end of a message that are still taken as padding."""


@cache
def typestore() -> Typestore:
    """Type store of ROS 2 Jazzy; made on first use (0.1 s)."""
    return get_typestore(Stores.ROS2_JAZZY)


@cache
def definition(type_name: str) -> str:
    """Text of a message definition with all it refers to, as an MCAP schema of encoding `ros2msg`."""
    return typestore().generate_msgdef(type_name, ros_version=2)[0]


@cache
def type_hash(type_name: str) -> str:
    """RIHS01 hash of a type, equal to `topic_type_hash` of the ROS graph."""
    return typestore().hash_rihs01(type_name)


def message(type_name: str, **fields: Any) -> Any:
    """A message object of the type store; every field must be given."""
    return typestore().types[type_name](**fields)


def serialize(content: Any, type_name: str) -> bytes:
    """Message object to CDR."""
    return bytes(typestore().serialize_cdr(content, type_name))


def deserialize(raw: bytes, type_name: str) -> Any:
    """CDR to message object.

    Fast DDS reserves four bytes too many for each empty sequence of doubles and sends them as well, which
    rosbags takes for a mismatch; so up to `SPARE_BYTES` at the end may be left over.

    Raises:
        MessageError: The bytes are not a message of this type.
    """
    for spare in range(0, SPARE_BYTES + 1, 4):
        try:
            return typestore().deserialize_cdr(raw[: len(raw) - spare], type_name)
        except SerdeError as error:
            if "size mismatch" not in str(error):
                raise _not_one(raw, type_name, error) from error
        except Exception as error:  # rosbags' generated code fails in many ways on bad bytes
            raise _not_one(raw, type_name, error) from error
    raise _not_one(raw, type_name, "bytes left over")


def _not_one(raw: bytes, type_name: str, reason: Exception | str) -> MessageError:
    return MessageError(
        f"expected the CDR bytes of a {type_name}, found {len(raw)} bytes that do not decode as one "
        f"({' '.join(str(reason).split())}); the writer uses another type or the bytes are damaged"
    )
