# SPDX-License-Identifier: Apache-2.0
"""Surface channels of a run: speed and torque of the drive, hookload, block."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.dynamics.sensors.sampling import Instrument, Reading
from drill_twin.scene import Scene
from drill_twin.scene.blocks.sensors import Surface

_INSTRUMENT = 1_000_000  # number of its noise, beyond those of the subs


class SurfaceValues(NamedTuple):
    """Measurements of a rig at the surface; numbers, or arrays of one shape."""

    speed: float | Array
    """Speed of the top drive [rad/s]."""
    torque: float | Array
    """Torque of the drive [N m]."""
    hookload: float | Array
    """Hookload [N]."""
    block_position: float | Array
    """Height of the travelling block above its start [m]."""


def drive_torque(
    torque: float | Array, speed: float | Array, acceleration: float | Array, inertia: float, damping: float
) -> float | Array:
    """Torque of a drive [N m]: on the string, on its own inertia and friction.

    Args:
        torque: Torque on the string [N m].
        speed: Speed of the drive [rad/s].
        acceleration: Its rate of change [rad/s^2].
        inertia: Inertia of the drive [kg m^2].
        damping: Viscous friction [N m s/rad].
    """
    return torque + inertia * acceleration + damping * speed


class SurfaceSampler:
    """Samples the surface channels of a scene."""

    def __init__(self, scene: Scene, surface: Surface, time: float, speed: float) -> None:
        """Begin at a time [s] and speed of the drive [rad/s]."""
        drive = scene.rig.top_drive
        self._inertia = drive.inertia if surface.drive_inertia is None else surface.drive_inertia
        self._damping = drive.damping
        self._time, self._speed = time, speed
        channels = (surface.speed, surface.torque, surface.hookload, surface.block_position)
        self._instrument = Instrument(channels, surface.rate, surface.delay, scene.numerics.seed, _INSTRUMENT)

    def advance(self, time: float, found: SurfaceValues) -> list[Reading]:
        """Advance to a time [s]; return the readings that are due, in the order of `SurfaceValues`.

        Args:
            time: End of the frame [s].
            found: True values, with the torque on the string.
        """
        seconds = time - self._time
        turned = (found.speed - self._speed) / seconds
        torque = drive_torque(found.torque, found.speed, turned, self._inertia, self._damping)
        self._time, self._speed = time, float(found.speed)
        sample = self._instrument.sample(time, seconds, np.array(found._replace(torque=torque)))
        return self._instrument.delayed(time, [] if sample is None else [sample])
