# SPDX-License-Identifier: Apache-2.0
"""Plain data from a JSON text of unknown origin, in bounded time and memory."""

import json
from typing import Any

from drill_twin.core.errors import DrillTwinError

LARGEST_TEXT = 1_000_000
"""Bytes or characters of a text."""
ODD_DATA = (LookupError, TypeError, ValueError, AttributeError, OverflowError)
"""Errors of a reader whose data are JSON, but not what it expects."""
_LONGEST_INTEGER = 300  # digits; a longer one is infinite as a float


class JsonError(DrillTwinError, ValueError):
    """A text that is not JSON, or beyond the bounds."""


def read_json(text: str | bytes, *, largest: int = LARGEST_TEXT) -> Any:
    """Plain data of a JSON text; an integer of more than 300 digits is infinite.

    Raises:
        JsonError: Malformed, too long, or too deep.
    """
    if len(text) > largest:
        raise JsonError(f"expected JSON of at most {largest} characters, found {len(text)}")
    try:
        return json.loads(text, parse_int=_integer)
    except (ValueError, RecursionError) as error:
        raise JsonError(f"expected JSON, found {text[:40]!r}") from error


def _integer(digits: str) -> int | float:
    return int(digits) if len(digits) <= _LONGEST_INTEGER else float(digits)
