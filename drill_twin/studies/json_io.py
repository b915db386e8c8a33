# SPDX-License-Identifier: Apache-2.0
"""Results of studies as JSON."""

from __future__ import annotations

import json
import math
from typing import Any

_CONFUSING = ((0x7F, 0xA0), (0x61C, 0x61D), (0x200B, 0x2010), (0x2028, 0x202F), (0x2060, 0x2070), (0xFEFF, 0xFF00))
_ESCAPED = {code: f"\\u{code:04x}" for begin, end in _CONFUSING for code in range(begin, end)}
"""Control and format characters that JSON allows in a text."""


def json_text(value: Any) -> str:
    """JSON text; numbers that are not finite become null."""
    return json.dumps(_finite(value), indent=2, allow_nan=False, ensure_ascii=False).translate(_ESCAPED) + "\n"


def _finite(value: Any) -> Any:
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else None
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    return value
