# SPDX-License-Identifier: Apache-2.0
"""Estimates on the live page, from messages of unknown origin: alarm, chance of whirl, and values with bands."""

from __future__ import annotations

from typing import Any

from drill_twin.errors import MessageError, printable
from drill_twin.io.messages.diagnostics import decode_diagnostics

_MOST = 50
_LONGEST_NAME, _LONGEST_TEXT = 60, 300
_OWN = "estimate"


def shown_estimates(raw: bytes) -> dict[str, Any]:
    """Level and sentence of a `/estimate/state`, and name and text, mean with its 90 % band, of each estimate.

    Raises:
        MessageError: It cannot be read, or has no status of the whole.
    """
    statuses = decode_diagnostics(raw)[1]
    whole = next((status for status in statuses if status.name == _OWN), None)
    if whole is None:
        raise MessageError(f"expected the status {_OWN!r} among the estimates, found none")
    try:
        chance = f"{float(whole.values['chance_of_whirl']):.0%}"
    except (KeyError, ValueError):
        chance = "unknown"
    rows = [
        {"name": _short(status.name.removeprefix(f"{_OWN}: "), _LONGEST_NAME), "text": _short(status.text)}
        for status in statuses[: _MOST + 1]
        if status is not whole
    ]
    return {
        "level": int(whole.level),
        "text": _short(whole.text),
        "rows": [{"name": "chance of whirl", "text": chance}, *rows],
    }


def _short(text: str, most: int = _LONGEST_TEXT) -> str:
    return printable(text[:most], keep="")
