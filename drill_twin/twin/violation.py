# SPDX-License-Identifier: Apache-2.0
"""What no state of a string can be, and what to do about it."""

from __future__ import annotations

from dataclasses import dataclass

NO_MATTER_OF_STEP = {"fold", "slope"}
"""What no smaller step mends: one try has to do."""
REMEDIES = {
    "finite": "look at the parameters of the effect that is named",
    "newton": "try a lower load (the string may have folded), a smaller numerics.step, more elements, or a softer wall",
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
    """What a state cannot be."""

    kind: str
    """finite, newton, speed, strain, fold, slope, penetration or energy."""
    node: int
    """Where it is worst."""
    text: str
    """What was found there and what was expected, in words."""
