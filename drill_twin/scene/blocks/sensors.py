# SPDX-License-Identifier: Apache-2.0
"""The `sensors:` part of a scene: downhole subs and surface channels, with their errors.

Noise and bias are drawn from `numerics.seed`.
"""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import Field, create_model

from drill_twin.core.units import (
    Acceleration,
    Angle,
    AngularSpeed,
    Force,
    Frequency,
    Inertia,
    Length,
    Time,
    Torque,
    Within,
)
from drill_twin.physics.effects.config import Part, Problem, repeated_names
from drill_twin.physics.effects.discs import PartName

_Rate = Annotated[Frequency, Within(above="0 Hz", at_most="10 kHz")]
_Delay = Annotated[Time, Within(at_least="0 s", at_most="1e4 s")]


class Channel(Part):
    """Errors of a measured quantity: reading = true value + bias + noise, limited to the range, in whole steps."""

    noise: float = 0.0
    bias: float = 0.0
    range: float = 0.0
    resolution: float = 0.0

    def problems(self) -> Iterator[Problem]:
        """Negative values."""
        for key in _MEANINGS:
            if getattr(self, key) < 0.0:
                yield (key,), f"expected 0 or more, found {getattr(self, key):g}"


_MEANINGS = {
    "noise": "Standard deviation of the noise of a sample [{}].",
    "bias": "Standard deviation of the constant offset, drawn once for each axis [{}].",
    "range": "Largest reading of either sign; 0: no limit [{}].",
    "resolution": "Step of the readings; 0: no quantisation [{}].",
}


def _channel(name: str, what: str, kind: Any, unit: str) -> type[Channel]:
    fields: Any = {key: (kind, Field(0.0, description=text.format(unit))) for key, text in _MEANINGS.items()}
    return create_model(name, __base__=Channel, __doc__=f"{what}: errors of the readings.", **fields)


if TYPE_CHECKING:
    Accelerometer = Channel
    Gyroscope = Channel
    SpeedChannel = Channel
    TorqueChannel = Channel
    ForceChannel = Channel
    LengthChannel = Channel
else:
    Accelerometer = _channel("Accelerometer", "Three accelerometers", Acceleration, "m/s^2")
    Gyroscope = _channel("Gyroscope", "Three gyroscopes", AngularSpeed, "rad/s")
    SpeedChannel = _channel("SpeedChannel", "Speed of rotation", AngularSpeed, "rad/s")
    TorqueChannel = _channel("TorqueChannel", "Torque", Torque, "N m")
    ForceChannel = _channel("ForceChannel", "Force", Force, "N")
    LengthChannel = _channel("LengthChannel", "Position", Length, "m")


class Sub(Part):
    """Sub with accelerometers and gyroscopes, on `/downhole/NAME/imu` and `/downhole/NAME/summary`."""

    name: PartName
    """Name on the topics: letters, digits and underscores, a letter first."""
    distance_from_bit: Annotated[Length, Within(at_least="0 m", at_most="20 km")]
    """Arc length of the sensor from the bit [m]."""
    radius: Annotated[Length, Within(at_least="0 m", at_most="10 m")] = 0.0
    """Distance of the sensor from the axis of the collar [m]."""
    angle: Angle = 0.0
    """Direction of the sensor in the collar, from the zero of the spin [rad]."""
    rate: _Rate
    """Samples in a second, at most `numerics.frame_rate` [Hz]; a sample is the mean since the last sample."""
    delay: _Delay = 0.0
    """Time from the measurement to its message [s]; the stamp is the time of the measurement."""
    summary: Annotated[Time, Within(at_least="0 s", at_most="1e4 s")] = 0.5
    """Time that a summary covers [s]; 0 s: no summaries."""
    accelerometer: Accelerometer = Accelerometer()
    """Accelerometers."""
    gyroscope: Gyroscope = Gyroscope()
    """Gyroscopes."""


class Surface(Part):
    """Channels of the rig at the surface, on `/surface/state`."""

    rate: _Rate
    """Samples in a second, at most `numerics.frame_rate` [Hz]."""
    delay: _Delay = 0.0
    """Time from the measurement to its message [s]; the stamp is the time of the measurement."""
    drive_inertia: Annotated[Inertia, Within(at_least="0 kg m^2", at_most="1e6 kg m^2")] | None = None
    """Inertia of the drive, whose acceleration its torque includes [kg m^2]; left out: the inertia of
    `rig.top_drive`."""
    speed: SpeedChannel = SpeedChannel()
    """Speed of the top drive."""
    torque: TorqueChannel = TorqueChannel()
    """Torque of the drive: on the string, on its own inertia and friction."""
    hookload: ForceChannel = ForceChannel()
    """Hookload."""
    block_position: LengthChannel = LengthChannel()
    """Position of the travelling block."""


class Sensors(Part):
    """Measurements of a rig, simulated with their errors."""

    subs: Annotated[tuple[Sub, ...], Field(max_length=100)] = ()
    """Downhole subs, in any order."""
    surface: Surface | None = None
    """Surface channels; left out: none."""

    def problems(self) -> Iterator[Problem]:
        """Names that two subs have."""
        yield from repeated_names("subs", self.subs)
