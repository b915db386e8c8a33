# SPDX-License-Identifier: Apache-2.0
"""Violations of the bounds of a plausible state, and their remedies."""

from __future__ import annotations

from dataclasses import dataclass

NOT_RETRIED = {"slow": 0, "long": 0, "fold": 1, "slope": 1}
"""Retries of the kinds that a smaller step does not mend."""
REMEDIES = {
    "finite": "look at the parameters of the effect that is named",
    "newton": "try a lower load (the string may have folded), a smaller numerics.step, more elements, or a softer wall",
    "slow": "try a softer contact or one with damping, fewer elements, or a longer numerics.processor_time",
    "long": "try a longer numerics.step, fewer elements, or a longer numerics.processor_time",
    "speed": "try a smaller numerics.step, or look at the parameters of the effect that is named",
    "strain": "try a lower load; no drillstring is meant to be stretched or squeezed so far",
    "fold": "try a lower load, or list `wall`, which keeps the string from folding",
    "fold in a hole": "try a lower load or speed: no wall keeps a string from kinking once it is wound up so far",
    "slope": "list `stretch` and `torsion` (the motion across the hole alone is meant for small slopes), or `wall`",
    "penetration": "try a smaller numerics.step, a stiffer wall, or a lower load",
    "energy": "try a smaller numerics.step or more elements",
}


@dataclass(frozen=True)
class Violation:
    """Violation of a bound by a state."""

    kind: str
    """finite, newton, slow (steps are cut), long (many steps), speed, strain, fold, slope, penetration or energy."""
    node: int
    """Node at which it is largest."""
    text: str
    """Description for messages: found and expected."""
