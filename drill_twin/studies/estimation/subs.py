# SPDX-License-Identifier: Apache-2.0
"""Downhole subs: what those of a member read over a window, and features of readings that can be compared.

Forces are means over frames, with impacts among them; their integral, turned out of the frame of the sub by its own
gyroscope, is the lateral velocity but for a constant, and smooth. Its mean is left out, and that of the force in the
frame of the sub, with the bias of the accelerometers, likewise: in the same way for the rig and for the members.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drill_twin.core.arrays import Array, ComplexArray, Mask
from drill_twin.core.errors import ArgumentError
from drill_twin.dynamics.sensors.motion import SubMotion, sub_motion, true_readings
from drill_twin.dynamics.sensors.subs import REAL, gravity_of, places_of, subs_by_name
from drill_twin.dynamics.twin.frame_record import NodeSeries
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.scene import Scene
from drill_twin.scene.blocks.sensors import Sub

VALUES = 6
"""Values of a reading: specific force [m/s^2] and rates of rotation [rad/s] about the axes of the sub."""
_ABSURD = 10.0
"""Largest force of a member in a window, times this: a larger one that is rare is absurd."""
_RARE = 0.1


def listed(scene: Scene, names: Sequence[str]) -> list[Sub]:
    """Subs of a scene by name, `measured/NAME` for those of a real rig.

    Raises:
        ArgumentError: The scene does not list one, or it is named twice.
    """
    known = subs_by_name(scene)
    wanted = [name.removeprefix(REAL) for name in names]
    if odd := [name for name, sub in zip(names, wanted, strict=True) if sub not in known or wanted.count(sub) > 1]:
        raise ArgumentError(
            f"subs: expected each once, of those that scene {scene.name} lists ({', '.join(known) or 'none'}), "
            f"found {', '.join(odd)}; list it under `sensors.subs` of the scene, or with --set"
        )
    return [known[name] for name in wanted]


class SubReader:
    """Perfect readings of subs in a twin."""

    def __init__(self, scene: Scene, twin: Twin, subs: Sequence[Sub]) -> None:
        places = places_of(subs, twin.rod)
        self._nodes = np.unique(np.concatenate((places.element, places.element + 1)))
        self._places = places._replace(element=np.searchsorted(self._nodes, places.element))
        self._gravity = gravity_of(scene)

    def start(self, twin: Twin) -> tuple[Array, Array]:
        """Node rows that carry the subs, before a window."""
        u, v = twin.unknowns
        return u[self._nodes], v[self._nodes]

    def read(self, before: tuple[Array, Array], states: NodeSeries, period: float) -> Array:
        """Means over the frames of a window, shape (F, s, 6).

        Args:
            before: As `start` returned them.
            states: The recorded frames.
            period: Length of a frame [s].
        """
        rows = (np.concatenate((w[None], of[:, self._nodes])) for w, of in zip(before, states[:2], strict=True))
        motion = sub_motion(self._places, *rows)
        first, last = SubMotion(*(part[:-1] for part in motion)), SubMotion(*(part[1:] for part in motion))
        return true_readings(self._places, first, last, period, self._gravity)


def sound(measured: Array, predicted: Array) -> Array:
    """Readings, with those left out that are rare and absurd beside the members: the one before stands for them.

    Args:
        measured: Shape (s, F, 6); NaN for a sub without readings.
        predicted: Of the members, shape (N, F, s, 6).
    """
    force = np.abs(measured[..., :3]).max(axis=2)
    largest = np.abs(predicted[..., :3]).max(axis=(0, 1, 3))
    off: Mask = force > _ABSURD * np.maximum(largest, 1.0)[:, None]
    off &= off.mean(axis=1, keepdims=True) < _RARE
    row = np.where(off, 0, np.arange(force.shape[1]))
    return np.take_along_axis(measured, np.maximum.accumulate(row, axis=1)[..., None], axis=1)


def lateral_velocity(readings: Array, period: float, samples: int) -> ComplexArray:
    """Lateral velocity about its mean, of means over the samples, shape (..., S) [m/s].

    Its direction is counted from that of the sensor at the start of the window.

    Args:
        readings: Shape (..., F, 6).
        period: Length of a frame [s].
        samples: Samples S of the F frames.
    """
    force = readings[..., 0] + 1j * readings[..., 1]
    spin = period * (np.cumsum(readings[..., 5], axis=-1) - 0.5 * readings[..., 5])
    steady = force - force.mean(axis=-1, keepdims=True)
    velocity = period * np.cumsum(steady * np.exp(1j * spin), axis=-1)
    means = _means(velocity, samples)
    return np.asarray(means - means.mean(axis=-1, keepdims=True))


def _means(values: NDArray[Any], samples: int) -> NDArray[Any]:
    return np.asarray(values.reshape(*values.shape[:-1], samples, values.shape[-1] // samples).mean(axis=-1))


def speed(readings: Array, samples: int) -> Array:
    """Speed of rotation, of means over the samples, shape (..., S) [rad/s]."""
    rate = readings[..., 5]
    return _means(rate, samples)


def velocity_noise(sub: Sub, window: float) -> float:
    """Standard deviation that the noise of the accelerometers leaves in `lateral_velocity` [m/s].

    That of a random walk in the middle between its ends, which the removed mean ties.
    """
    return 0.5 * sub.accelerometer.noise * math.sqrt(window / sub.rate)
