# SPDX-License-Identifier: Apache-2.0
"""Operations of the rig whose loads are wanted: steady motion of the whole string along and about the hole."""

from typing import NamedTuple

TRIP_SPEED = 0.3
"""Speed along the hole when tripping [m/s], about 60 ft/min; the friction of a Coulomb law does not depend on it."""
FEED = 5e-3
"""Rate of penetration in sliding and drilling [m/s], 18 m/h: beside the speed of the rotating surface it is small."""


class Operation(NamedTuple):
    """Steady operation of the rig."""

    name: str
    """As in the tables."""
    weight_on_bit: float
    """[N]."""
    axial_speed: float
    """Speed of the string along the hole [m/s]; upwards is positive."""
    rotation: float
    """Speed of rotation [rad/s]."""

    @property
    def is_on_bottom(self) -> bool:
        """True if the bit carries weight."""
        return self.weight_on_bit != 0.0


def operations(
    weight_on_bit: float, rotation: float, trip_speed: float = TRIP_SPEED, feed: float = FEED
) -> tuple[Operation, ...]:
    """The five operations of a well plan; without a rotation or a weight on bit only the operations that need none.

    Args:
        weight_on_bit: When sliding and drilling [N].
        rotation: When rotating and drilling [rad/s].
        trip_speed: When tripping [m/s].
        feed: Rate of penetration when sliding and drilling [m/s].
    """
    possible = {
        Operation("trip out", 0.0, trip_speed, 0.0): True,
        Operation("trip in", 0.0, -trip_speed, 0.0): True,
        Operation("off bottom", 0.0, 0.0, rotation): bool(rotation),
        Operation("slide", weight_on_bit, -feed, 0.0): bool(weight_on_bit),
        Operation("drill", weight_on_bit, -feed, rotation): bool(rotation and weight_on_bit),
    }
    return tuple(operation for operation, is_wanted in possible.items() if is_wanted)
