# SPDX-License-Identifier: Apache-2.0
"""DiagnosticArray: level, sentence and named values as text for each component."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import IntEnum

from drill_twin.io.messages.stamps import header, header_stamp
from drill_twin.io.messages.topic_row import DIAGNOSTIC_ARRAY
from drill_twin.io.messages.type_store import deserialize, message, serialize


class Level(IntEnum):
    """Levels of diagnostic_msgs/DiagnosticStatus."""

    OK, WARN, ERROR, STALE = range(4)


@dataclass(frozen=True)
class Status:
    """Status of one component."""

    name: str
    """Component, as `simulator: guard`."""
    level: Level
    """Severity."""
    text: str
    """One sentence."""
    values: Mapping[str, str] = field(default_factory=dict)
    """Named values as text; floats by `exact`, so that they are read back bit for bit."""
    hardware_id: str = ""
    """Subject: the name of a mark, or `drill_twin` and the namespace of the node's twin."""


def exact(value: float) -> str:
    """Shortest text that is read back as the same float."""
    return repr(float(value))


def encode_diagnostics(stamp: int, statuses: Sequence[Status], frame_id: str = "") -> bytes:
    """CDR of a DiagnosticArray at a stamp [ns]."""
    content = message(
        DIAGNOSTIC_ARRAY,
        header=header(stamp, frame_id),
        status=[
            message(
                "diagnostic_msgs/msg/DiagnosticStatus",
                level=int(status.level),
                name=status.name,
                message=status.text,
                hardware_id=status.hardware_id,
                values=[
                    message("diagnostic_msgs/msg/KeyValue", key=key, value=value)
                    for key, value in status.values.items()
                ],
            )
            for status in statuses
        ],
    )
    return serialize(content, DIAGNOSTIC_ARRAY)


def decode_diagnostics(raw: bytes) -> tuple[int, list[Status]]:
    """Stamp [ns] and statuses of a DiagnosticArray.

    Raises:
        MessageError: Not a DiagnosticArray.
    """
    content = deserialize(raw, DIAGNOSTIC_ARRAY)
    statuses = [
        Status(
            name=item.name,
            level=Level(item.level) if item.level in set(Level) else Level.ERROR,
            text=item.message,
            values={pair.key: pair.value for pair in item.values},
            hardware_id=item.hardware_id,
        )
        for item in content.status
    ]
    return header_stamp(content), statuses
