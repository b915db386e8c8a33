# SPDX-License-Identifier: Apache-2.0
"""Estimates on the live page, from messages of unknown origin: trust, chance of whirl, and values with bands."""

from __future__ import annotations

import math
from typing import Any

from drill_twin.core.errors import MessageError
from drill_twin.core.units.system import QUANTITIES
from drill_twin.io.messages.decode import JointState
from drill_twin.io.messages.diagnostics import Level
from drill_twin.live.plain import number, short
from drill_twin.studies.estimation import SENSORS

_MOST = 50
_LONGEST_NAME = 60
_ENDS = ("/low", "/high")
_LIKELY = 0.5
"""Chance of whirl from which the page warns."""


def shown_estimates(state: JointState) -> dict[str, Any]:
    """Levels of a `/estimate/state`, and rows of it for the page.

    A row has name, mean, low and high end of its 90 % band; one with a unit also its quantity, and the values in the
    page's own unit, which the page shows in the reader's. `trust` is the level of the trust in them; of unusable ones
    there are no rows.

    Raises:
        MessageError: It has neither trust nor alarm.
    """
    values = dict(zip(state.names, state.position.tolist(), strict=False))
    if not {"trust", "alarm"} <= values.keys():
        raise MessageError(f"expected trust and alarm among the estimates, found {', '.join(state.names) or 'none'}")
    trust = Level.OK if values["trust"] == 0.0 else Level.WARN if values["trust"] == 1.0 else Level.ERROR
    chance = values.get("chance_of_whirl", math.nan)
    level = Level.ERROR if values["alarm"] else max(trust, Level.WARN if chance >= _LIKELY else Level.OK)
    named = [name for name in values if all(name + end in values for end in _ENDS)]
    rows = [{"name": "chance of whirl", "mean": number(chance), "low": None, "high": None}]
    rows += [_row(name, values) for name in named[:_MOST]]
    return {"level": int(level), "trust": int(trust), "rows": [] if trust is Level.ERROR else rows}


def _row(name: str, values: dict[str, float]) -> dict[str, Any]:
    unit = "m" if name.endswith(("/x", "/y")) else SENSORS.get(name, "")
    quantity = "offset" if unit == "m" else QUANTITIES.get(unit, "")  # radii and places across the hole
    factor = 1.0 / math.tau if quantity == "rotation" else 1.0  # to the page's own unit
    mean, low, high = (number(factor * values[name + end]) for end in ("", *_ENDS))
    shown = short(name, _LONGEST_NAME)
    band = {"mean": mean, "low": low, "high": high}
    return {"name": shown.replace("_", " "), "quantity": quantity, **band} if quantity else {"name": shown, **band}
