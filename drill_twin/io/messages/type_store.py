# SPDX-License-Identifier: Apache-2.0
"""Message definitions, type hashes and general CDR for ROS 2 Jazzy, from rosbags' type store.

A message takes 10 to 1000 us here; `cdr` and `decode` have faster ways for the topics at full rate.
"""

from functools import cache
from typing import Any

from rosbags.serde import SerdeError
from rosbags.typesys import Stores, get_typestore
from rosbags.typesys.store import Typestore

from drill_twin.core.errors import MessageError

CDR_LITTLE_ENDIAN = b"\x00\x01\x00\x00"
"""Encapsulation, the first four bytes of a message; alignment counts from their end."""

SPARE_BYTES = 16
"""Most bytes after the end of a message that are taken as padding."""


@cache
def typestore() -> Typestore:
    """Type store of ROS 2 Jazzy, made on first use (0.1 s)."""
    return get_typestore(Stores.ROS2_JAZZY)


@cache
def definition(type_name: str) -> str:
    """Message definition with the definitions that it depends on, as an MCAP schema of encoding `ros2msg`."""
    return typestore().generate_msgdef(type_name, ros_version=2)[0]


@cache
def type_hash(type_name: str) -> str:
    """RIHS01 hash of a type, equal to `topic_type_hash` of the ROS graph."""
    return typestore().hash_rihs01(type_name)


def message(type_name: str, **fields: Any) -> Any:
    """Message object of the type store; every field must be given."""
    return typestore().types[type_name](**fields)


def serialize(content: Any, type_name: str) -> bytes:
    """CDR of a message object."""
    return bytes(typestore().serialize_cdr(content, type_name))


def deserialize(raw: bytes, type_name: str) -> Any:
    """Message object of CDR bytes.

    Fast DDS sends four bytes too many for each empty sequence of doubles, which rosbags refuses; so up to
    `SPARE_BYTES` at the end are accepted.

    Raises:
        MessageError: The bytes are not a message of this type.
    """
    for spare in range(0, SPARE_BYTES + 1, 4):
        try:
            return typestore().deserialize_cdr(raw[: len(raw) - spare], type_name)
        except SerdeError as error:
            if "size mismatch" not in str(error):
                raise _decode_error(raw, type_name, error) from error
        except Exception as error:  # the generated code of rosbags fails in many ways on damaged bytes
            raise _decode_error(raw, type_name, error) from error
    raise _decode_error(raw, type_name, "bytes left over")


def _decode_error(raw: bytes, type_name: str, reason: Exception | str) -> MessageError:
    return MessageError(
        f"expected the CDR bytes of a {type_name}, found {len(raw)} bytes that do not decode "
        f"({' '.join(str(reason).split())}); the writer uses another type or the bytes are damaged"
    )
