# SPDX-License-Identifier: Apache-2.0
"""Messages of measurements: readings and summaries of subs, surface channels."""

from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.errors import MessageError
from drill_twin.dynamics.sensors.sampling import Reading
from drill_twin.dynamics.sensors.subs import SUMMARY
from drill_twin.io.messages.cdr import JointStateTemplate, Template, check_finite, sentinel_header, sentinels
from drill_twin.io.messages.decode import JointArrays
from drill_twin.io.messages.stamps import header_stamp, stamp_ns
from drill_twin.io.messages.topic_row import IMU
from drill_twin.io.messages.topics import FRAME_ID, SURFACE_STATE, imu_topic, summary_topic
from drill_twin.io.messages.type_store import deserialize, message

_SURFACE_JOINTS = ("top_drive", "block")


class ImuReading(NamedTuple):
    """Reading of a sub."""

    stamp: int
    """Header stamp [ns]."""
    values: Array
    """Specific force [m/s^2] and rate of rotation [rad/s] about the axes of the sub, shape (6,)."""
    frame_id: str = ""
    """Frame of the sub."""


class ImuEncoder:
    """Encoder of `/downhole/SUB/imu` for one sub; the attitude is unknown (REP 145).

    Raises:
        MessageError: Raised by `encode` for a reading that is not finite.
    """

    def __init__(self, sub: str, force_noise: float, rate_noise: float, prefix: str = "") -> None:
        """Make the template.

        Args:
            sub: Name of the sub, and of the frame.
            force_noise: Standard deviation of the noise of the accelerometers [m/s^2].
            rate_noise: Of the gyroscopes [rad/s].
            prefix: Put before the name of the frame.
        """
        blocks = [sentinels(3, 1), sentinels(3, 2)]
        force, rate = (
            message("geometry_msgs/msg/Vector3", x=x, y=y, z=z) for x, y, z in (block.tolist() for block in blocks)
        )
        content = message(
            IMU,
            header=sentinel_header(prefix + sub),
            orientation=message("geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=0.0, w=1.0),
            orientation_covariance=np.array([-1.0, *[0.0] * 8]),
            angular_velocity=rate,
            angular_velocity_covariance=(rate_noise**2 * np.eye(3)).ravel(),
            linear_acceleration=force,
            linear_acceleration_covariance=(force_noise**2 * np.eye(3)).ravel(),
        )
        self._topic = imu_topic(sub)
        self._template = Template(content, IMU, blocks)

    def encode(self, reading: Reading) -> bytes:
        """CDR of a reading, six values."""
        check_finite(self._topic, reading.values)
        return self._template.rows([stamp_ns(reading.time)], *reading.values.reshape(2, 1, 3))[0]


class SummaryEncoder:
    """Encoder of `/downhole/SUB/summary` for one sub.

    Raises:
        MessageError: Raised by `encode` for a value that is not finite.
    """

    def __init__(self, sub: str, prefix: str = "") -> None:
        self._topic = summary_topic(sub)
        self._template = JointStateTemplate(SUMMARY, velocity=False, effort=False, frame_id=prefix + sub)

    def encode(self, reading: Reading) -> bytes:
        """CDR of a summary, in the order of `SUMMARY`."""
        check_finite(self._topic, reading.values)
        return self._template.fill(stamp_ns(reading.time), reading.values)


class SurfaceEncoder:
    """Encoder of `/surface/state`: what is measured of top drive and block, and what a rig's display derives from it.

    The angle of the top drive is the integral of its measured speed, the velocity of the block the difference of its
    measured positions; both are 0 in the first message.

    Raises:
        MessageError: Raised by `encode` for a value that is not finite.
    """

    def __init__(self, prefix: str = "") -> None:
        self._template = JointStateTemplate(_SURFACE_JOINTS, frame_id=prefix + FRAME_ID)
        self._before: tuple[float, float] | None = None  # time and position of the block
        self._angle = 0.0

    def encode(self, reading: Reading) -> bytes:
        """CDR of a reading, in the order of `drill_twin.dynamics.sensors.sampling.SurfaceValues`."""
        check_finite(SURFACE_STATE, reading.values)
        speed, torque, hookload, position = reading.values.tolist()
        time, at = self._before or (reading.time, position)
        seconds = reading.time - time
        self._angle += seconds * speed
        self._before = reading.time, position
        lift = (position - at) / seconds if seconds > 0.0 else 0.0
        return self._template.fill(stamp_ns(reading.time), (self._angle, position), (speed, lift), (torque, hookload))


def read_imu(raw: bytes) -> ImuReading:
    """Decode a sensor_msgs/Imu of any writer.

    Raises:
        MessageError: Not an Imu.
    """
    content = deserialize(raw, IMU)
    force, rate = content.linear_acceleration, content.angular_velocity
    values = np.array([force.x, force.y, force.z, rate.x, rate.y, rate.z])
    return ImuReading(header_stamp(content), values, content.header.frame_id)


def read_summary(states: JointArrays) -> Array:
    """Values of a summary or of several in the order of `SUMMARY`, NaN where there is none, shape (..., 10).

    Raises:
        MessageError: The messages have none of the values.
    """
    if not set(SUMMARY) & set(states.names):
        raise MessageError(f"expected values such as {SUMMARY[0]}, found {', '.join(states.names) or 'none'}")
    return np.stack([states.column("position", name) for name in SUMMARY], axis=-1)
