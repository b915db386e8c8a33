# SPDX-License-Identifier: Apache-2.0
"""Advice and operating map on the live page, from messages of unknown origin."""

from __future__ import annotations

import math
from typing import Any

from drill_twin.core.errors import MessageError
from drill_twin.core.files.json_files import read_json
from drill_twin.io.messages.decode import JointState
from drill_twin.io.messages.diagnostics import Level
from drill_twin.live.plain import short
from drill_twin.studies.maps.advice import AdviceCode
from drill_twin.studies.maps.regimes import COLOURS

SHOWN_STEPS = 64
"""Steps of the map along each range on the page; a finer one is shown at every second node, or fewer."""
_MOST_STEPS = 1024


def shown_advice(state: JointState) -> dict[str, Any]:
    """Level of a `/advice/state`, and the set-point that is advised, `wob` [N] and `rps` [rev/s], if there is one.

    Raises:
        MessageError: It has no advice.
    """
    values = dict(zip(state.names, state.position.tolist(), strict=False))
    if "advice" not in values:
        raise MessageError(f"expected the code of an advice, found {', '.join(state.names) or 'none'}")
    level = {AdviceCode.NEAR: Level.WARN, AdviceCode.LEAVE: Level.ERROR}.get(values["advice"], Level.OK)
    shown: dict[str, Any] = {"level": int(level)}
    target = [values.get(f"target/{name}", math.nan) for name in ("weight_on_bit", "rotation")]
    if values.get("target") and all(map(math.isfinite, target)):
        shown |= {"wob": target[0], "rps": target[1] / math.tau}
    return shown


def shown_map(text: str) -> dict[str, Any]:
    """Ranges in N and rev/s, and a digit a node for regime, whirl from rest and whirl that goes on.

    Raises:
        MessageError: It is no map of `/advice/map`.
    """
    data = read_json(text, largest=4 * (_MOST_STEPS + 1) ** 2)
    try:
        steps = int(data["steps"])
        (low, high), (slow, fast) = (map(float, data[name]) for name in ("weight_on_bit_N", "rotation_rad_s"))
        every, side = max(1, steps // SHOWN_STEPS), steps + 1
        fields = {name: str(data[name]) for name in ("codes", "whirls", "keeps")}
        names, digest, window = list(data["regimes"]), str(data["digest"]), data["safe_window"]
        edges = [low, high, slow, fast, *map(float, window or ())]
        good = 1 <= steps <= _MOST_STEPS and low < high and slow < fast and all(map(math.isfinite, edges))
        if not (good and all(len(digits) == side**2 and digits.isdigit() for digits in fields.values())):
            raise ValueError(f"{steps} steps")
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        raise MessageError(f"expected an operating map, found another text ({type(error).__name__})") from error
    rows = range(0, side, every)
    return {
        "digest": digest[:64],
        "colours": COLOURS,
        "wob": [low, high],
        "rps": [slow / math.tau, fast / math.tau],
        "regimes": [short(str(name), 40) for name in names[:10]],
        "window": edges[4:6] + [edge / math.tau for edge in edges[6:]],
        **{name: "".join(digits[i * side + j] for i in rows for j in rows) for name, digits in fields.items()},
    }
