# SPDX-License-Identifier: Apache-2.0
"""Measurements of a bag as arrays over time: readings and summaries of downhole subs, surface channels."""

from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.errors import MessageError
from drill_twin.io.bag.reader import Bag
from drill_twin.io.bag.series import JointSeries, RigSeries
from drill_twin.io.bag.time_series import Column, Series
from drill_twin.io.messages.decode import JointStates
from drill_twin.io.messages.rig_messages import read_measured_states
from drill_twin.io.messages.sensor_messages import read_imu, read_summary
from drill_twin.io.messages.topics import MEASURED, MEASURED_RIG_STATE, SURFACE_STATE, TWIN_SCENE, sub_of


class ImuSeries(Series):
    """`/downhole/SUB/imu`, in the axes of the sub: x outwards, y in the sense of rotation, z towards the top."""

    force = Column(slice(0, 3))
    """Specific force [m/s^2], shape (T, 3)."""
    rate = Column(slice(3, 6))
    """Rate of rotation [rad/s], shape (T, 3)."""

    def add_message(self, raw: bytes) -> None:
        """Append a message.

        Raises:
            MessageError: The message cannot be decoded, or has a number that is not finite.
        """
        if not np.isfinite((reading := read_imu(raw)).values).all():
            raise MessageError("expected readings of a sub, found a number that is not finite")
        self.append(reading.stamp, reading.values)


class SummarySeries(JointSeries):
    """`/downhole/SUB/summary`; each of shape (T,), NaN where the tool does not send it."""

    speed_least = Column(0)
    """[rad/s]"""
    speed_mean = Column(1)
    """[rad/s]"""
    speed_largest = Column(2)
    """[rad/s]"""
    radial_mean = Column(3)
    """[m/s^2]"""
    radial_rms = Column(4)
    """[m/s^2]"""
    radial_peak = Column(5)
    """[m/s^2]"""
    tangential_rms = Column(6)
    """[m/s^2]"""
    tangential_peak = Column(7)
    """[m/s^2]"""
    axial_rms = Column(8)
    """[m/s^2]"""
    axial_peak = Column(9)
    """[m/s^2]"""

    def _values(self, states: JointStates) -> tuple[Array, tuple[str, ...]]:
        return read_summary(states), ()


class SurfaceSeries(RigSeries):
    """`/surface/state` or `/measured/rig/state`, NaN where nothing was measured."""

    def _values(self, states: JointStates) -> tuple[Array, tuple[str, ...]]:
        return read_measured_states(states), ()


class SubSeries(NamedTuple):
    """Readings and summaries of a downhole sub."""

    imu: ImuSeries
    """Readings."""
    summary: SummarySeries
    """Summaries."""


class Measured:
    """Measurements of the last run in a bag."""

    def __init__(self, bag: Bag) -> None:
        """Read the measurements; a message that cannot be used is left out and counted."""
        self.skipped = 0
        """Messages that could not be used."""
        self._reset()
        topics = [name for name in bag.topics if sub_of(name) or name in {SURFACE_STATE, MEASURED_RIG_STATE}]
        scene = b""
        for topic, _, raw in bag.messages([TWIN_SCENE, *topics]) if topics else ():
            if topic == TWIN_SCENE:
                if scene and raw != scene:
                    self._reset()
                scene = raw
                continue
            try:
                self._series(topic).add_message(raw)
            except MessageError:
                self.skipped += 1

    def _reset(self) -> None:
        self.subs: dict[str, SubSeries] = {}
        """Subs by name; subs of a real rig as `measured/NAME`."""
        self.surface = SurfaceSeries()
        """Surface channels of a simulated rig."""
        self.rig = SurfaceSeries()
        """Surface channels of a real rig."""

    def _series(self, topic: str) -> ImuSeries | SummarySeries | SurfaceSeries:
        if name := sub_of(topic):
            key = f"measured/{name}" if topic.startswith(MEASURED) else name
            sub = self.subs.setdefault(key, SubSeries(ImuSeries(), SummarySeries()))
            return sub.imu if topic.endswith("/imu") else sub.summary
        return self.surface if topic == SURFACE_STATE else self.rig
