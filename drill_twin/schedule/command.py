# SPDX-License-Identifier: Apache-2.0
"""What the rig sets at one moment."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Command:
    """Both set-points of the rig."""

    weight_on_bit: float
    """Weight on bit [N]; negative pulls."""
    rotation: float
    """Speed of the top drive [rad/s]; positive is right-handed about the upward axis."""
