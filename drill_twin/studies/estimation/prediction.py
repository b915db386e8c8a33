# SPDX-License-Identifier: Apache-2.0
"""Prediction of a window by the members of the ensemble: channels, virtual sensors, readings of subs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from drill_twin.core.arrays import Array, Mask

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


@dataclass(frozen=True)
class Pace:
    """Lengths in time.

    Attributes:
        period: Of a frame [s].
        frames: Frames of a window.
        samples: Samples of a window.
    """

    period: float
    frames: int
    samples: int

    @property
    def window(self) -> float:
        """Length of a window [s]."""
        return self.period * self.frames


@dataclass(frozen=True)
class Prediction:
    """A window of N members.

    Attributes:
        channels: By name, shape (N, S): means over the samples (`drill_twin.runs.ensemble.outputs.series.Channels`).
        sensors: Virtual sensors by name, each of shape (N,).
        whirls: Whether each member whirls, shape (N,).
        readings: Of the subs, shape (N, F, s, 6) (`drill_twin.studies.estimation.subs`).
    """

    channels: Mapping[str, Array]
    sensors: Mapping[str, Array]
    whirls: Mask
    readings: Array
