# SPDX-License-Identifier: Apache-2.0
"""Results in plain types, and as JSON."""

import json
import math
from enum import Enum
from typing import Any

_CONFUSING = ((0x7F, 0xA0), (0x61C, 0x61D), (0x200B, 0x2010), (0x2028, 0x202F), (0x2060, 0x2070), (0xFEFF, 0xFF00))
_ESCAPED = {code: f"\\u{code:04x}" for begin, end in _CONFUSING for code in range(begin, end)}
"""Control and format characters that JSON allows in a text."""


def json_text(value: Any) -> str:
    """JSON text; numbers that are not finite become null."""
    return json.dumps(plain(value), indent=2, allow_nan=False, ensure_ascii=False).translate(_ESCAPED) + "\n"


def plain(value: Any) -> Any:
    """Value in plain types for JSON: states by name, and None for a number that is not finite."""
    if type(value).__module__ == "numpy":  # which is not imported here: the help of a command needs none
        value = value.tolist()
    if isinstance(value, Enum):
        return value.value
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else None
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    return value
