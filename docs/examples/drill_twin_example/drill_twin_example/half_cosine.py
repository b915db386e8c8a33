# SPDX-License-Identifier: Apache-2.0
"""Shape of a set-point: half a period of a cosine from its initial to its final value."""

import math
from collections.abc import Callable

from drill_twin.scene.blocks.rig import SetPoint


def half_cosine(set_point: SetPoint) -> Callable[[float], float]:
    """Value [SI] over time [s]; `initial` before `start`, `value` from `start + duration` on."""
    before, after = set_point.initial, set_point.value

    def value(time: float) -> float:
        since = time - set_point.start
        if since >= set_point.duration:
            return after
        return before + (after - before) * 0.5 * (1.0 - math.cos(math.pi * max(since, 0.0) / set_point.duration))

    return value
