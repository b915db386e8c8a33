# SPDX-License-Identifier: Apache-2.0
"""Quantities of the twin that the gateway can show, from the messages of its topics."""

import json
import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from drill_twin.core.errors import MessageError
from drill_twin.core.rig_channels import FIELDS, channel_of
from drill_twin.core.units import Dimension
from drill_twin.core.units.dimension import ACCELERATION, ANGULAR_SPEED, DIMENSIONLESS, FORCE, LENGTH, TIME
from drill_twin.dynamics.sensors.subs import SUMMARY
from drill_twin.io.messages.decode import JointState, PoseArray
from drill_twin.io.messages.good_samples import GoodSamples
from drill_twin.io.messages.readers import reader_of
from drill_twin.io.messages.rig_messages import read_rig_state
from drill_twin.io.messages.stamps import NANOSECONDS, seconds
from drill_twin.io.messages.topics import (
    ADVICE_MAP,
    ADVICE_STATE,
    MARKS_STATE,
    REALTIME_FACTOR,
    RIG_STATE,
    STRING_POSES,
    TWIN_SUMMARY,
    WHIRL_ONSET,
    WHIRL_STATE,
    sub_of,
    summary_topic,
)
from drill_twin.io.messages.whirl_encode import WHIRL_SCALARS, OnsetMessage, read_whirl_state
from drill_twin.whirl import MotionCode, StickSlip

ANGULAR_ACCELERATION = Dimension("angular acceleration", "rad/s^2", ("3 rad/s^2",))


class RigQuantity(NamedTuple):
    """Quantity that the topics carry, or that follows from them."""

    topic: str
    """Topic that it comes from."""
    dimension: Dimension
    """Dimension; values are in its SI unit."""
    meaning: str
    """Definition, for the description of its node."""


_RIG = (
    "weight_on_bit", "surface_rotation", "surface_torque", "bit_rotation", "bit_torque", "hookload", "block_position",
    "block_velocity", "rate_of_penetration",
)  # fmt: skip
_KINDS = {
    "forward": (MotionCode.FORWARD_WHIRL, MotionCode.SYNCHRONOUS_WHIRL),
    "backward": (MotionCode.BACKWARD_WHIRL, MotionCode.ROLLING, MotionCode.CREEPING),
    "chaotic": (MotionCode.IRREGULAR,),
}
"""Motion states of a mark that are a kind of whirl of D-WIS."""
_SEVERITIES = {
    "severity": "lateral acceleration and stick-slip",
    "lateral_severity": "lateral acceleration in the last 5 s",
}
_SAFE = {
    f"safe_{name}_{end}": f"{which} {words} of the window of the operating map that stays calm"
    for name, words in (("weight", "weight on bit"), ("rotation", "speed"))
    for end, which in (("low", "smallest"), ("high", "largest"))
}
_MEANINGS = {
    "weight_on_bit": "weight on bit as applied, positive in compression",
    "hookload": "upward force on the string at the top",
}
QUANTITIES = {
    **{name: RigQuantity(RIG_STATE, channel_of(name).dimension, _MEANINGS.get(name) or channel_of(name).heading)
       for name in _RIG},
    "bit_angular_acceleration": RigQuantity(RIG_STATE, ANGULAR_ACCELERATION, "change of the bit's speed over a frame"),
    "stick_slip_severity": RigQuantity(
        RIG_STATE,
        DIMENSIONLESS,
        "(fastest - slowest) / (2 mean) of the bit's speed in the last 20 s (Pavone and Desplans 1994)",
    ),
    "simulated_time": RigQuantity(RIG_STATE, TIME, "simulated time"),
    "bit_depth": RigQuantity(STRING_POSES, LENGTH, "depth of the bit below the top clamp along the axis at the top"),
    "wall_force": RigQuantity(MARKS_STATE, FORCE, "largest normal force of the wall at a mark"),
    "axial_acceleration": RigQuantity(MARKS_STATE, ACCELERATION, "axial acceleration of the lowest mark, over a frame"),
    "lateral_acceleration": RigQuantity(
        MARKS_STATE, ACCELERATION, "lateral acceleration of the mark where it is largest, over a frame"
    ),
    "whirl_orbit_radius": RigQuantity(WHIRL_STATE, LENGTH, "radius of the largest orbit of a mark"),
    "whirl_precession": RigQuantity(WHIRL_STATE, ANGULAR_SPEED, "precession of that mark, positive forward"),
    "whirl_ratio": RigQuantity(WHIRL_STATE, DIMENSIONLESS, "whirl ratio of that mark"),
    "whirl_confidence": RigQuantity(WHIRL_STATE, DIMENSIONLESS, "confidence of these, 0 to 1"),
    **{f"whirl_{kind}": RigQuantity(WHIRL_STATE, DIMENSIONLESS, f"1 while the whirl of that mark is {kind}, else 0")
       for kind in _KINDS},
    "whirl_state": RigQuantity(
        TWIN_SUMMARY,
        DIMENSIONLESS,
        "motion of the string: " + ", ".join(f"{code:d} {code.state.value}" for code in MotionCode),
    ),
    **{name: RigQuantity(TWIN_SUMMARY, DIMENSIONLESS, f"severity of {what}, 0 none to 4 severe")
       for name, what in _SEVERITIES.items()},
    "whirl_detected": RigQuantity(WHIRL_ONSET, DIMENSIONLESS, "1 once a whirl has begun, else 0"),
    "whirl_onset": RigQuantity(WHIRL_ONSET, TIME, "simulated time of the first onset of whirl"),
    "advised_weight_on_bit": RigQuantity(ADVICE_STATE, FORCE, "weight on bit of the nearest calmer set-point"),
    "advised_rotation": RigQuantity(ADVICE_STATE, ANGULAR_SPEED, "speed of the nearest calmer set-point"),
    **{name: RigQuantity(ADVICE_MAP, FORCE if "weight" in name else ANGULAR_SPEED, meaning)
       for name, meaning in _SAFE.items()},
    "real_time_factor": RigQuantity(REALTIME_FACTOR, DIMENSIONLESS, "simulated over wall time"),
}  # fmt: skip
"""Quantities by name."""

MEASURED = {name: (channel_of(name).joint, channel_of(name).array) for name in _RIG}
"""Quantities that a rig measures, with their joint and array on `/measured/rig/state`."""


def downhole(quantity: str) -> tuple[str, str]:
    """Name of the sub and value of its summary, of a quantity such as `near_bit.speed_mean`; empty for others."""
    sub, _, value = quantity.partition(".")
    return (sub, value) if sub_of(summary_topic(sub)) and value in SUMMARY else ("", "")


def measured_dimension(quantity: str) -> Dimension:
    """Dimension of a quantity that a rig measures."""
    _, value = downhole(quantity)
    if value:
        return ANGULAR_SPEED if value.startswith("speed") else ACCELERATION
    return QUANTITIES[quantity].dimension


class TwinQuantities:
    """Latest value of each quantity [SI], and the age of the last good sample of its topic."""

    def __init__(self, samples: GoodSamples | None = None) -> None:
        """Start without values; what comes is noted in samples by topic, of a node or of its own."""
        self._marks: JointState | None = None
        self._bit: tuple[float, float] | None = None
        self._bit_motion = StickSlip()
        self.values: dict[str, float] = {}
        """Values by name [SI]; a quantity that does not exist in this run is missing."""
        self.samples = samples or GoodSamples()
        """Good and bad samples by topic."""
        self.samples.longest[ADVICE_STATE] = 1.0
        self.stamp = 0
        """Stamp of the last `/rig/state` [ns]."""
        self._take: dict[str, Callable[[Any], bool]] = {
            RIG_STATE: self._on_rig,
            MARKS_STATE: self._on_marks,
            STRING_POSES: self._on_poses,
            WHIRL_STATE: self._on_whirl,
            WHIRL_ONSET: self._on_onset,
            TWIN_SUMMARY: self._on_summary,
            ADVICE_STATE: self._on_advice,
            ADVICE_MAP: self._on_map,
            REALTIME_FACTOR: self._on_factor,
        }
        self._read = {topic: reader_of(topic) for topic in self._take}

    def take(self, topic: str, raw: bytes) -> None:
        """Use a message of a topic.

        Raises:
            MessageError: The message cannot be read.
        """
        try:
            finite = self._take[topic](self._read[topic](raw))
        except MessageError:
            self.samples.unreadable(topic)
            raise
        self.samples.take(topic, finite=finite)

    # Each returns whether the message has a finite number.

    def _on_rig(self, message: JointState) -> bool:
        state, time = read_rig_state(message), seconds(message.stamp)
        self.values.update({name: getattr(state, FIELDS[name]) for name in _RIG})
        if state.drilled == 0.0:  # this bit does not drill, or not yet
            del self.values["rate_of_penetration"]
        if self._bit is not None and 0.0 < time - self._bit[0] < 1.0:
            self.values["bit_angular_acceleration"] = (state.bit_speed - self._bit[1]) / (time - self._bit[0])
        self._bit, self.stamp = (time, state.bit_speed), message.stamp
        self._bit_motion.push(time, state.bit_speed, state.top_drive_speed)
        self.values["stick_slip_severity"] = self._bit_motion.index
        if math.isnan(self._bit_motion.index):
            del self.values["stick_slip_severity"]
        self.values["simulated_time"] = time
        return message.has_number

    def _on_marks(self, now: JointState) -> bool:
        before = self._marks
        if len(now.names) % 4 or now.velocity.size != len(now.names) or now.effort.size != len(now.names):
            raise MessageError(
                f"expected four joints a mark with velocity and effort on /marks/state, found {len(now.names)} names"
            )
        self._marks = now
        force = now.effort.reshape(-1, 4)[:, :2]
        self.values["wall_force"] = float(np.hypot(force[:, 0], force[:, 1]).max(initial=0.0))
        if before is None or before.names != now.names or not 0 < now.stamp - before.stamp < NANOSECONDS:
            return now.has_number
        rate = (now.velocity - before.velocity).reshape(-1, 4) / seconds(now.stamp - before.stamp)
        lowest = int(now.position.reshape(-1, 4)[:, 2].argmin())
        self.values["axial_acceleration"] = float(rate[lowest, 2])
        self.values["lateral_acceleration"] = float(np.hypot(rate[:, 0], rate[:, 1]).max())
        return now.has_number

    def _on_poses(self, poses: PoseArray) -> bool:
        position = poses.position
        if position.size:
            self.values["bit_depth"] = -float(position[0, 2])
        return bool(np.isfinite(position).any())

    def _on_whirl(self, message: JointState) -> bool:
        _, marks = read_whirl_state(message)
        orbits = marks[np.isfinite(marks[:, 0])]  # none yet, or none any more
        *found, motion = orbits[orbits[:, 0].argmax()].tolist() if orbits.size else [math.nan] * len(WHIRL_SCALARS)
        for name, value in zip(WHIRL_SCALARS, found, strict=False):
            self.values[f"whirl_{name}"] = value
        for kind, codes in _KINDS.items():
            self.values[f"whirl_{kind}"] = float(motion in codes)
        return True

    def _on_factor(self, factor: float) -> bool:
        self.values["real_time_factor"] = factor
        return math.isfinite(factor)

    def _on_onset(self, found: tuple[int, OnsetMessage | None]) -> bool:
        self.values["whirl_detected"] = float(found[1] is not None)
        self.values["whirl_onset"] = math.nan if found[1] is None else found[1].time
        return True

    def _on_summary(self, message: JointState) -> bool:
        self.values["whirl_state"] = message.position[message.index("whirl")]
        for name in _SEVERITIES:
            grade = message.position[message.index(name)]
            self.values[name] = grade if grade >= 0.0 else math.nan
        return message.has_number

    def _on_advice(self, message: JointState) -> bool:
        is_given = message.position[message.index("target")] == 1.0
        for name in ("weight_on_bit", "rotation"):
            value = message.position[message.index(f"target/{name}")]
            self.values[f"advised_{name}"] = value if is_given else math.nan
        return True

    def _on_map(self, text: str) -> bool:
        try:
            window = json.loads(text)["safe_window"] or [math.nan] * len(_SAFE)
            self.values |= zip(_SAFE, map(float, window), strict=True)
        except (KeyError, TypeError, ValueError) as error:
            raise MessageError(f"expected a safe_window of four numbers on {ADVICE_MAP}, found none") from error
        return True
