# SPDX-License-Identifier: Apache-2.0
"""Set-points of the rig at one instant."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Command:
    """Set-points of the rig."""

    weight_on_bit: float
    """Weight on bit [N]; negative = tension."""
    rotation: float
    """Speed of the top drive [rad/s]; positive is right-handed about the upward axis."""
