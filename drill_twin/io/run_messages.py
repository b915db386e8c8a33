# SPDX-License-Identifier: Apache-2.0
"""Messages of a run beside the messages of its frames: what its sensors measure, and the text of `/twin/scene`.

By this text a bag tells what was run; the sensors are the subs and surface channels that the scene lists.
"""

from collections.abc import Iterator
from datetime import UTC, datetime

import yaml

from drill_twin.core import __version__
from drill_twin.core.arrays import Array
from drill_twin.dynamics.sensors.sampling import SurfaceSampler, SurfaceValues
from drill_twin.dynamics.sensors.subs import SubSampler
from drill_twin.dynamics.twin.frame import RigState
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.io.messages.sensor_messages import ImuEncoder, SummaryEncoder, SurfaceEncoder
from drill_twin.io.messages.topics import SURFACE_STATE, imu_topic, summary_topic
from drill_twin.scene import Scene


def sensor_topics(scene: Scene) -> tuple[str, ...]:
    """Topics of the sensors of a scene."""
    if scene.sensors is None:
        return ()
    subs = [topic for sub in scene.sensors.subs for topic in (imu_topic(sub.name), summary_topic(sub.name))]
    return (*subs, SURFACE_STATE) if scene.sensors.surface is not None else tuple(subs)


class Measurements:
    """Samples the sensors of a twin frame by frame, and encodes what they read."""

    def __init__(self, twin: Twin, frame_prefix: str = "") -> None:
        """Begin with the present state of a twin; the prefix is put before the names of frames."""
        scene, sensors = twin.scene, twin.scene.sensors
        subs = () if sensors is None else sensors.subs
        surface = None if sensors is None else sensors.surface
        self._subs = SubSampler(scene, twin.rod, twin.time, *twin.unknowns) if subs else None
        speed = float(twin.unknowns[1][-1, 6])
        self._surface = None if surface is None else SurfaceSampler(scene, surface, twin.time, speed)
        self._imu = {
            sub.name: ImuEncoder(sub.name, sub.accelerometer.noise, sub.gyroscope.noise, frame_prefix) for sub in subs
        }
        self._summary = {sub.name: SummaryEncoder(sub.name, frame_prefix) for sub in subs}
        self._surface_encoder = SurfaceEncoder(frame_prefix)

    def messages(self, time: float, u: Array, v: Array, rig: RigState) -> Iterator[tuple[str, bytes]]:
        """Topics and bytes of what is due after a frame.

        Args:
            time: Its time [s].
            u: Node rows (r, r', psi) at its end, shape (n + 1, 7).
            v: Their velocities.
            rig: State of rig and bit.
        """
        if self._subs is not None:
            for sub, readings, summaries in self._subs.advance(time, u, v):
                yield from ((imu_topic(sub.name), self._imu[sub.name].encode(one)) for one in readings)
                yield from ((summary_topic(sub.name), self._summary[sub.name].encode(one)) for one in summaries)
        if self._surface is not None:
            found = SurfaceValues(rig.top_drive_speed, rig.top_drive_torque, rig.hookload, rig.block_position)
            for reading in self._surface.advance(time, found):
                yield SURFACE_STATE, self._surface_encoder.encode(reading)


def describe_run(twin: Twin, pace: str = "fast") -> str:
    """Text of `/twin/scene`: the resolved scene (YAML) with a `run` block of version, seed, resolution and effects.

    Args:
        twin: The twin.
        pace: Pace of the run: realtime, fast or lockstep.
    """
    run = {
        "version": __version__,
        "seed": int(twin.scene.numerics.seed),
        "elements": int(twin.elements),
        "step_s": float(twin.step_size),
        "effects": [str(name) for name in twin.scene.effect_names],
        "pace": pace,
        "started": datetime.now(UTC).isoformat(timespec="milliseconds"),
    }
    return f"{twin.scene.to_yaml().rstrip()}\n{yaml.safe_dump({'run': run}, sort_keys=False)}"
