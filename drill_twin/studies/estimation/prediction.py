# SPDX-License-Identifier: Apache-2.0
"""Prediction of a window by the members: channels, virtual sensors, readings of subs; bands over the members."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from drill_twin.core.arrays import Array, Mask
from drill_twin.core.units.system import UnitSystem

SHARE = 0.9
"""Share of the members in a band: the probability of the true value if the members were draws of what is known."""


HELD = (
    f"low and high are bands of {SHARE:.0%}; on twins with hidden numbers they held the truth in 88 to 100 % (by kind "
    "of quantity); doubtful after a jump that no number explains: bit speed and bit torque, 79 to 81 %; wrong "
    "after a step too small to be reported, as of friction at the bit of a whirling rod"
)
"""Shares that bands have held, as measured by `drill-twin study estimator-score` (docs/bands.md)."""


@dataclass(frozen=True)
class Band:
    """Mean, standard deviation, and band of 90 % of the members; how often it holds the truth: `HELD`."""

    mean: float
    deviation: float
    low: float
    high: float

    @classmethod
    def of(cls, values: Array, factor: float = 1.0) -> Band:
        """Band of the values of the members, shape (N,), widened about their mean by a factor."""
        mean = values.mean()
        low, high = mean + factor * (np.quantile(values, (0.5 - 0.5 * SHARE, 0.5 + 0.5 * SHARE)) - mean)
        low = max(low, 0.0) if values.min() >= 0.0 else low
        return cls(float(mean), factor * float(values.std(ddof=1)), float(low), float(high))


SENSORS: Mapping[str, str] = {
    "weight_on_bit": "N",
    "bit_speed": "rad/s",
    "bit_torque": "N m",
    "radius": "m",
    "wall_force": "N",
    "bending_stress": "Pa",
}
"""Virtual sensors and their units: bit and weight on it at the end of the window, largest radius of a mark and largest
wall force of a node in it, largest bending stress at its end."""


def unit_of(sensor: str) -> str:
    """Unit of a virtual sensor; places of marks are in m."""
    return SENSORS.get(sensor, "m")


def shown_unit(sensor: str, units: UnitSystem) -> tuple[float, str]:
    """Number of the reader's units in one of `unit_of`, and their name; radii and places are offsets."""
    unit = unit_of(sensor)
    return (float(units.show(1.0, "offset")), units.offset) if unit == "m" else units.in_unit(unit)


_REACH = 2.5
"""Time before a window [s] that its means may reach back to: the slowest record is one of 0.5 Hz, whose stamps vary."""


@dataclass(frozen=True)
class WindowTiming:
    """Lengths in time.

    Attributes:
        period: Of a frame [s].
        frames: Frames of a window.
        samples: Samples of a window, at most.
    """

    period: float
    frames: int
    samples: int

    @property
    def window(self) -> float:
        """Length of a window [s]."""
        return self.period * self.frames

    @property
    def tail(self) -> int:
        """Frames before a window that its means may reach back to."""
        return math.ceil(_REACH / self.period)


@dataclass(frozen=True)
class Prediction:
    """A window of N members.

    Attributes:
        channels: By name, shape (N, S): means over the time of each sample of the window, 0 where there is none.
        sensors: Virtual sensors by name, each of shape (N,).
        whirls: Whether each member whirls, shape (N,).
        readings: Of the subs, shape (N, F, s, 6) (`drill_twin.studies.estimation.subs`).
    """

    channels: Mapping[str, Array]
    sensors: Mapping[str, Array]
    whirls: Mask
    readings: Array
