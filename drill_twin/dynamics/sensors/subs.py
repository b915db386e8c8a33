# SPDX-License-Identifier: Apache-2.0
"""Downhole subs of a run: readings and summaries, frame by frame."""

import math
from collections.abc import Iterator, Sequence

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.dynamics.sensors.motion import SubPlaces, locate, sub_motion, true_readings
from drill_twin.dynamics.sensors.sampling import Instrument, Reading
from drill_twin.physics.model.mesh import Rod
from drill_twin.scene import Scene
from drill_twin.scene.blocks.sensors import Sub

SUMMARY = (
    "speed_least", "speed_mean", "speed_largest", "radial_mean", "radial_rms", "radial_peak", "tangential_rms",
    "tangential_peak", "axial_rms", "axial_peak",
)  # fmt: skip
"""Values of a summary: speed of rotation [rad/s]; accelerations [m/s^2], rms and peak about their mean."""


def summary(readings: Array) -> Array:
    """Summary of n readings, shape (..., n, 6), in the order of `SUMMARY`, shape (..., 10)."""
    speed, force = readings[..., 5], readings[..., :3]
    mean = force.mean(-2, keepdims=True)
    rms, peak = np.sqrt(((force - mean) ** 2).mean(-2)), np.abs(force - mean).max(-2)
    columns = [speed.min(-1), speed.mean(-1), speed.max(-1), mean[..., 0, 0]]
    columns += [part[..., axis] for axis in range(3) for part in (rms, peak)]
    return np.stack(columns, -1)


REAL = "measured/"
"""Prefix of the name of a sub of a real rig."""


def subs_of(scene: Scene) -> Sequence[Sub]:
    """Subs that a scene lists."""
    return () if scene.sensors is None else scene.sensors.subs


def subs_by_name(scene: Scene) -> dict[str, Sub]:
    """Subs that a scene lists, by name."""
    return {sub.name: sub for sub in subs_of(scene)}


def places_of(subs: Sequence[Sub], rod: Rod) -> SubPlaces:
    """Places of subs in a mesh."""
    columns = [(sub.distance_from_bit, sub.radius, sub.angle) for sub in subs]
    return locate(rod, *np.array(columns).reshape(-1, 3).T)


def gravity_of(scene: Scene) -> Array:
    """Acceleration of free fall in the frame `hole` [m/s^2], shape (3,); zero in a scene without gravity."""
    magnitude = 0.0 if scene.effects.gravity is None else scene.effects.gravity.magnitude
    inclination = scene.hole.top_inclination
    return magnitude * np.array([math.sin(inclination), 0.0, -math.cos(inclination)])


class SubSampler:
    """Samples the subs of a scene."""

    def __init__(self, scene: Scene, rod: Rod, time: float, u: Array, v: Array) -> None:
        """Begin with a state.

        Args:
            scene: The scene, with subs.
            rod: The meshed string.
            time: Time of the state [s].
            u: Node rows (r, r', psi), shape (n + 1, 7).
            v: Their velocities.
        """
        self._subs = subs_of(scene)
        self._places, self._gravity = places_of(self._subs, rod), gravity_of(scene)
        self._time, self._before = time, sub_motion(self._places, u, v)
        self._instruments = [
            Instrument((*[sub.accelerometer] * 3, *[sub.gyroscope] * 3), sub.rate, sub.delay, scene.numerics.seed, k)
            for k, sub in enumerate(self._subs)
        ]
        self._summarised: list[list[Reading]] = [[] for _ in self._subs]

    def advance(self, time: float, u: Array, v: Array) -> Iterator[tuple[Sub, list[Reading], list[Reading]]]:
        """Advance to a state; yield the readings (six values) and summaries of each sub that has any.

        Args:
            time: Time of the state [s].
            u: Node rows (r, r', psi), shape (n + 1, 7).
            v: Their velocities.
        """
        after, seconds = sub_motion(self._places, u, v), time - self._time
        true = true_readings(self._places, self._before, after, seconds, self._gravity)
        self._time, self._before = time, after
        for sub, instrument, values, kept in zip(self._subs, self._instruments, true, self._summarised, strict=True):
            if due := instrument.advance(time, seconds, values):
                yield sub, due, list(_summaries(sub, due, kept))


def _summaries(sub: Sub, readings: Sequence[Reading], kept: list[Reading]) -> Iterator[Reading]:
    """Summaries of the windows that readings end; readings of the open window are in `kept`."""
    for reading in readings:
        if sub.summary > 0.0 and kept and reading.time // sub.summary > kept[-1].time // sub.summary:
            end = (kept[-1].time // sub.summary + 1.0) * sub.summary
            yield Reading(end, summary(np.array([one.values for one in kept])))
            kept.clear()
        if sub.summary > 0.0:
            kept.append(reading)
