# SPDX-License-Identifier: Apache-2.0
"""Topics of a bag as arrays over time; T samples in recorded order."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drill_twin.base.arrays import Array
from drill_twin.io.messages.pose import spin_of
from drill_twin.io.messages.stamps import NANOSECONDS

Stamps = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Series:
    """What every series has: T samples in recorded order."""

    stamp: Stamps
    """Header stamps [ns], shape (T,)."""

    @property
    def time(self) -> Array:
        """Header stamps as time [s], shape (T,)."""
        return self.stamp / NANOSECONDS


@dataclass(frozen=True, eq=False)
class JointSeries(Series):
    """A JointState topic; k joints. An array the messages leave empty has shape (T, 0)."""

    names: tuple[str, ...]
    """Joint names."""
    position: Array
    """Shape (T, k)."""
    velocity: Array
    """Shape (T, k)."""
    effort: Array
    """Shape (T, k)."""


@dataclass(frozen=True, eq=False)
class PoseSeries(Series):
    """`/string/poses`; n + 1 nodes, 0 = bit."""

    position: Array
    """Positions [m], shape (T, n + 1, 3)."""
    orientation: Array
    """Unit quaternions x y z w, shape (T, n + 1, 4)."""

    @property
    def spin(self) -> Array:
        """Spins [rad], unwrapped over time, shape (T, n + 1)."""
        return np.unwrap(spin_of(self.orientation), axis=0, period=4.0 * np.pi)


@dataclass(frozen=True, eq=False)
class MarkSeries(Series):
    """`/marks/state`; m marks."""

    names: tuple[str, ...]
    """Names of the marks."""
    position: Array
    """Positions [m], shape (T, m, 3)."""
    spin: Array
    """Spins [rad], not wrapped, shape (T, m)."""
    velocity: Array
    """Velocities [m/s], shape (T, m, 3)."""
    spin_rate: Array
    """Spin rates [rad/s], shape (T, m)."""
    wall_force: Array
    """Normal wall forces [N], shape (T, m)."""


@dataclass(frozen=True, eq=False)
class RigSeries(Series):
    """`/rig/state`; each field as in `drill_twin.twin.frame.RigState`, shape (T,)."""

    top_drive_angle: Array
    top_drive_speed: Array
    top_drive_torque: Array
    bit_angle: Array
    bit_speed: Array
    bit_torque: Array
    bit_force: Array
    block_position: Array
    block_velocity: Array
    hookload: Array


@dataclass(frozen=True, eq=False)
class CommandSeries(Series):
    """`/rig/command`."""

    weight_on_bit: Array
    """Weight on bit [N], shape (T,)."""
    rotation: Array
    """Top-drive speed [rad/s], shape (T,)."""


@dataclass(frozen=True, eq=False)
class WhirlSeries(Series):
    """`/whirl/state`; m marks."""

    names: tuple[str, ...]
    """Names of the marks."""
    orbit_radius: Array
    """Radius of the centre line's orbit [m], shape (T, m)."""
    precession: Array
    """Precession [rev/s], positive = forward, shape (T, m)."""
    ratio: Array
    """Precession over rotation, shape (T, m)."""
    confidence: Array
    """Confidence, 0 to 1, shape (T, m)."""
