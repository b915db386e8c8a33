# SPDX-License-Identifier: Apache-2.0
"""Soft string, without bending stiffness, on the wall of the hole (Johancsik and others 1984); buckling of pipe there;
the steady operations of the rig whose loads are wanted.

The force that presses an element to the wall is N = |w + T k n|, with the weight across the hole w, tension T,
curvature k of the hole and its normal n. Friction mu N acts against the motion of the surface, split between the
direction along the hole and that around it. Above the helical buckling load the helix presses with its own force too.

Pipe snakes at a compression, and forms a helix at a larger one.

* Sinusoidal: F_s = 2 sqrt(EI w / r), w the force per length that presses the pipe to the wall, r the radial clearance
  (Dawson and Paslay 1984; with w of a curved hole: He and Kyllingstad 1995, Mitchell 1999). In a vertical hole, where w
  is zero, 1.94 (EI q^2)^(1/3) with the weight per length q (Lubinski 1950).
* Helical: sqrt(2) F_s (Chen, Lin and Cheatham 1990); 5.55 (EI q^2)^(1/3) in a vertical hole (Wu, Juvkam-Wold and Lu
  1993). Between sqrt(2) and 2 sqrt(2) F_s both shapes are possible, above it only the helix (Mitchell 1997).
"""

import math
from collections.abc import Callable
from enum import IntEnum
from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array

CHEN, MITCHELL = np.sqrt(2.0), 2.0 * np.sqrt(2.0)
"""Helical load over sinusoidal load: the least at which a helix persists, and the least at which only a helix does."""
LUBINSKI, WU = 1.94, 5.55
"""Factors of (EI q^2)^(1/3) in a vertical hole: sinusoidal and helical."""

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


class BucklingState(IntEnum):
    """Shape of the pipe under its compression."""

    STRAIGHT = 0
    SINUSOIDAL = 1
    SINUSOIDAL_OR_HELICAL = 2
    HELICAL = 3

    @property
    def label(self) -> str:
        """Name in tables."""
        return self.name.lower().replace("_", " ")


class BucklingLoads(NamedTuple):
    """Compression of buckling along the string, shape (n,) each."""

    sinusoidal: Array
    """[N]."""
    helical: Array
    """Least load of the helix [N]."""

    def states(self, tension: Array) -> Array:
        """`BucklingState` of each element under an effective tension [N]."""
        share = np.maximum(-tension, 0.0) / np.maximum(self.sinusoidal, 1e-300)
        upper = np.maximum(-tension, 0.0) / np.maximum(self.helical, 1e-300)
        steps = (share > 1.0).astype(int) + (upper > 1.0) + (upper > MITCHELL / CHEN)
        return np.asarray(steps)

    def margins(self, tension: Array) -> tuple[float, float]:
        """Least of sinusoidal and of helical load over the compression; infinite where nothing is compressed."""
        squeezed = tension < 0.0
        if not squeezed.any():
            return math.inf, math.inf
        sinusoidal, helical = (float((load[squeezed] / -tension[squeezed]).min()) for load in self)
        return sinusoidal, helical


def buckling_loads(bending: Array, pressing: Array, weight: Array, clearance: Array) -> BucklingLoads:
    """Compression at which pipe buckles.

    Args:
        bending: EI [N m2].
        pressing: Force per length that presses the unbuckled pipe to the wall, w [N/m].
        weight: Buoyant weight per length, q [N/m].
        clearance: Radial clearance r [m].
    """
    snaking = 2.0 * np.sqrt(bending * pressing / clearance)
    vertical = np.cbrt(bending * weight**2)
    return BucklingLoads(np.maximum(snaking, LUBINSKI * vertical), np.maximum(CHEN * snaking, WU * vertical))


ITERATIONS = 4
"""Of the tension at the middle of an element."""
EVEN = 0.81
"""Least over largest square of the curvature in an element that has one bend; chosen."""
MOST_WEIGHT = 1e8
"""Compression [N] that no pipe transmits: where friction and helix add up to it, the string is locked."""


class HoleAndString(NamedTuple):
    """Elements of the string in the hole, from the bit up; shape (n,), or (n, p, 3) for vectors at p places inside."""

    length: Array
    """[m]."""
    weight: Array
    """Buoyant weight per length along the hole, positive where it pulls towards the bit [N/m]."""
    across: Array
    """Buoyant weight per length across the hole [N/m], shape (n, p, 3)."""
    bend: Array
    """Curvature times its normal [1/m], shape (n, p, 3)."""
    bending: Array
    """EI [N m2]."""
    radius: Array
    """Contact radius of the string [m]."""
    clearance: Array
    """[m]."""
    friction: Array
    """Coefficient mu."""

    def pressing(self, tension: Array) -> Array:
        """Mean force per length that presses the elements to the wall under a tension [N/m], shape (n,)."""
        force = self.across + tension[:, None, None] * self.bend
        return np.asarray(np.linalg.norm(force, axis=2).mean(axis=1))

    def buckling(self, tension: Array) -> BucklingLoads:
        """Buckling loads under a tension, by the force that presses the unbuckled string."""
        weight = np.hypot(self.weight, np.linalg.norm(self.across, axis=2).mean(axis=1))
        return buckling_loads(self.bending, self.pressing(tension), weight, self.clearance)


class SoftString(NamedTuple):
    """Soft string in an operation: tension and torque at the nodes from the bit up, shape (n + 1,).

    NaN from the node up at which the string locks (`MOST_WEIGHT`): no push from above reaches the bit.
    """

    tension: Array
    """[N]."""
    torque: Array
    """[N m]."""
    side_force: Array
    """Per length, in the elements [N/m], shape (n,)."""

    @property
    def hookload(self) -> float:
        """Tension at the top [N]; NaN of a string that locks."""
        return float(self.tension[-1])

    @property
    def surface_torque(self) -> float:
        """Torque at the top, with the sign of the rotation [N m]; NaN of a string that locks."""
        return float(self.torque[-1])


def soft_string(string: HoleAndString, operation: Operation, bit_torque: float = 0.0) -> SoftString:
    """Integrate tension and torque from the bit up.

    A helix presses on the wall with r F^2 / (4 EI) per length (Lubinski, Althouse and Logan 1962).

    Args:
        string: Elements.
        operation: The operation; at zero speed there is no friction.
        bit_torque: Torque at the bit, with the sign of the rotation [N m].
    """
    around = operation.rotation * string.radius
    speed = np.maximum(np.hypot(operation.axial_speed, around), 1e-300)
    along = operation.axial_speed / speed * string.friction
    turning = around / speed * string.friction * string.radius
    # N^2 = |w|^2 + 2 T w.kn + T^2 k^2, at all places of an element in which the bend changes, as at a station
    pairs = (string.across, string.across), (string.across, string.bend), (string.bend, string.bend)
    squares = np.stack([np.sum(one * other, axis=2) for one, other in pairs], axis=2)
    mean, bend2 = squares.mean(axis=1), squares[:, :, 2]
    uneven = bend2.min(axis=1) < EVEN * bend2.max(axis=1)
    places = [part.tolist() if many else [own.tolist()] for part, own, many in zip(squares, mean, uneven, strict=True)]
    helical = WU**3 * string.bending * (string.weight**2 + mean[:, 0])  # cube of the helical load of a vertical hole
    stiff, gap = string.bending, string.clearance
    tension, torque, side = [-operation.weight_on_bit], [bit_torque], []
    rows = np.column_stack([string.length, string.weight, along, turning, helical, stiff, gap]).tolist()
    for (length, weight, drag, lever, vertical, bending, clearance), inside in zip(rows, places, strict=True):
        here = above = tension[-1]
        for _ in range(ITERATIONS):
            middle = 0.5 * (here + above)
            at = [math.sqrt(max(w2 + middle * (2.0 * wk + middle * k2), 0.0)) for w2, wk, k2 in inside]
            force = pressing = sum(at) / len(at)
            snaking2 = 4.0 * bending * pressing / clearance  # square of the sinusoidal load
            if middle < 0.0 and middle * middle > CHEN**2 * snaking2 and -(middle**3) > vertical:
                force += clearance * middle * middle / (4.0 * bending)
            above = max(here + (weight + drag * force) * length, -MOST_WEIGHT)
        side.append(force)
        tension.append(above)
        torque.append(torque[-1] + lever * force * length)
    kept = np.where(np.logical_or.accumulate(np.array(tension) <= -MOST_WEIGHT), np.nan, 1.0)
    return SoftString(kept * tension, kept * torque, kept[1:] * side)


def lock_up_weight(string: HoleAndString, operation: Operation) -> float:
    """Weight on bit at which sliding takes the whole hookload: more cannot be set off by slacking off [N].

    Zero where the string does not slide in by its own weight at all.
    """
    return _largest_weight(string, operation, lambda soft: soft.hookload > 0.0)


def straight_weight(string: HoleAndString, operation: Operation) -> float:
    """Weight on bit from which the string buckles, with the sinusoidal load [N]; 0 where it does without any."""

    def straight(soft: SoftString) -> bool:
        tension = 0.5 * (soft.tension[1:] + soft.tension[:-1])
        return math.isfinite(soft.hookload) and string.buckling(tension).margins(tension)[0] > 1.0

    return _largest_weight(string, operation, straight)


def _largest_weight(string: HoleAndString, operation: Operation, holds: Callable[[SoftString], bool]) -> float:
    """Weight on bit up to which something holds of the soft string [N]."""

    def held(weight: float) -> bool:
        return holds(soft_string(string, operation._replace(weight_on_bit=weight)))

    low, high = 0.0, 1e3
    if not held(low):
        return 0.0
    while held(high) and high < MOST_WEIGHT:
        low, high = high, 2.0 * high
    for _ in range(20):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if held(middle) else (low, middle)
    return low
