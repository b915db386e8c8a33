# SPDX-License-Identifier: Apache-2.0
"""Estimates on the live page, from messages of unknown origin: alarm, chance of whirl, and values with bands."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from drill_twin.core.errors import MessageError
from drill_twin.io.messages.diagnostics import Level, Status
from drill_twin.live.plain import short

_MOST = 50
_LONGEST_NAME = 60
_TRUST = {"good": Level.OK, "doubtful": Level.WARN, "unusable": Level.ERROR}
_OWN, _BAND = "estimate", ("mean", "low", "high")
_QUANTITIES = {
    "N": ("force", 1.0),
    "rad/s": ("rotation", 1.0 / math.tau),
    "N m": ("torque", 1.0),
    "m": ("offset", 1.0),
    "Pa": ("stress", 1.0),
}
"""Quantity of the page (`units.js`) by the unit of an estimate, and the factor to the page's own unit."""


def shown_estimates(statuses: Sequence[Status]) -> dict[str, Any]:
    """Level and sentence of a `/estimate/state`, and rows of it for the page.

    A row has name and text; an estimate with a unit of `_QUANTITIES` also its quantity, and mean, low and high end of
    its 90 % band in the page's own unit, which the page shows in the reader's. For doubtful estimates `trust` is the
    level of a warning; of unusable ones there are no rows.

    Raises:
        MessageError: It has no status of the whole.
    """
    whole = next((status for status in statuses if status.name == _OWN), None)
    if whole is None:
        raise MessageError(f"expected the status {_OWN!r} among the estimates, found none")
    chance = _number(whole, "chance_of_whirl")
    trust = _TRUST.get(whole.values.get("estimates", ""), Level.WARN if whole.level == Level.ERROR else Level.OK)
    rows = [{"name": "chance of whirl", "text": "unknown" if chance is None else f"{chance:.0%}"}]
    rows += [_row(status) for status in statuses[: _MOST + 1] if status is not whole]
    return {
        "level": int(whole.level),
        "text": short(whole.text),
        "trust": int(trust),
        "rows": [] if trust is Level.ERROR else rows,
    }


def _row(status: Status) -> dict[str, Any]:
    name = short(status.name.removeprefix(f"{_OWN}: "), _LONGEST_NAME)
    shown: dict[str, Any] = {"name": name, "text": short(status.text)}
    quantity, factor = _QUANTITIES.get(status.text.partition(") ")[2], ("", 1.0))
    band = {key: factor * value for key in _BAND if (value := _number(status, key)) is not None}
    if quantity and len(band) == len(_BAND):
        shown |= {"name": name.replace("_", " "), "quantity": quantity, **band}
    return shown


def _number(status: Status, key: str) -> float | None:
    """Finite number of a status; None where it has none."""
    try:
        value = float(status.values[key])
    except (KeyError, ValueError):
        return None
    return value if math.isfinite(value) else None
