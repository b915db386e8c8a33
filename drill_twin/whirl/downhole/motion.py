# SPDX-License-Identifier: Apache-2.0
"""Lateral motion of a section from the readings of a sub, reading by reading.

Gyroscopes give attitude and spin. The lateral specific force, turned back by the spin, is the acceleration of the
centre line, plus the lever arm of the sensor (r Omega^2, r dOmega/dt) and gravity by the tilt of the section; both are
removed; what is constant in the frame of the string (bias, bow) is the mean over the first revolutions at a steady
speed. What remains is integrated twice, less its drift (`high_pass`): the position about its mean, for whirls above the
corner of the high pass.
"""

import cmath
import math
from collections import deque
from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array, ComplexArray
from drill_twin.whirl import criteria
from drill_twin.whirl.downhole.high_pass import GRAVITY, HighPass, ToolNoise, corner_for
from drill_twin.whirl.downhole.sub_findings import ImpactCounter, TorsionEstimator

SLOWEST = 0.06
"""Least corner of the high pass over the rotation [-].

The numbers of this file were chosen, not measured by themselves; `evidence/docs/detection.md` judges them together."""
CALIBRATION = 4.0
"""Length of the record over which constants are found [rev]."""
STEADY = 0.02
"""Largest change of the mean speed from one half of that length to the other [-]."""
PATIENCE = 30.0
"""After so many revolutions the speed need not be steady [rev]."""
MEMORY = 32.0
"""Length of the record that is kept for the time of an onset [rev]."""
MOST_KEPT = 100_000
"""Most readings that are kept."""
LONGEST_GAP = 0.125
"""Missing readings are interpolated over at most this part of a revolution [rev]."""
UNEVEN = 0.5
"""A reading is missing where the interval is longer than usual by this share [-]."""


class Place(NamedTuple):
    """Place of a section at the end of a reading."""

    stamp: int
    """End of the reading [ns]."""
    position: complex
    """x + i y of the centre line about its mean [m]; x where the sensor pointed at first."""
    spin: float
    """Spin since the first reading [rad]."""
    speed: float
    """Speed of rotation [rad/s]."""


class Kept(NamedTuple):
    """A reading as it is kept: acceleration [m/s^2] without gravity by the tilt, and what turns it."""

    stamp: int
    acceleration: complex
    tilt: complex
    turn: complex
    axial: float
    spin: float
    speed: float
    revolutions: float


class MotionRecord(NamedTuple):
    """The last readings as arrays, shape (n,)."""

    stamp: Array
    """Ends of the readings [s]."""
    acceleration: ComplexArray
    """Lateral acceleration in the frame of the hole, and constants [m/s^2]."""
    turn: ComplexArray
    """Unit vector of the spin."""
    revolutions: Array
    """[rev]"""
    whole: bool
    """True if the readings go back to the first reading of the analysis."""


class SubMotion:
    """Lateral motion of the section of a sub, from the readings that come in."""

    def __init__(self, radius: float, clearance: float, noise: ToolNoise) -> None:
        """Begin before the first reading.

        Args:
            radius: Distance of the sensor from the axis of the collar [m].
            clearance: Lateral clearance of the section [m].
            noise: Noise of the instruments.
        """
        self._radius, self._clearance, self._noise = radius, clearance, noise
        self.impacts = ImpactCounter(clearance, noise)
        """Impacts on the wall."""
        self.torsion = TorsionEstimator()
        """Stick-slip of the section."""
        self._spin = self.revolutions = 0.0
        """Revolutions so far [rev]."""
        self._restart()

    def _restart(self) -> None:
        self._kept: deque[Kept] = deque(maxlen=MOST_KEPT)
        self._waiting: list[tuple[int, list[float]]] = []
        self._interval, self._whole = 0, True
        self._tilt, self._axial, self._synchronous, self._due = 0j, GRAVITY, 0j, 0.0
        self._begin = self.revolutions
        self.impacts.restart()
        self._filter: HighPass | None = None
        self.corner = 0.0
        """Corner of the high pass [rad/s]: slower whirls are not seen; 0 before there is one."""

    @property
    def interval(self) -> float:
        """Time between readings [s]."""
        return self._interval * 1e-9

    def push(self, stamp: int, values: list[float]) -> list[Place]:
        """Add a reading, later than the readings before; return the places that it completes.

        The lever arm needs the acceleration of the spin: a place is the place of the reading before.

        Args:
            stamp: Middle of the reading [ns].
            values: Specific force [m/s^2] and rates [rad/s] in the axes of the sub, six values.
        """
        if not self._waiting:
            self._waiting = [(stamp, values)]
            return []
        last, before = self._waiting[-1]
        step = stamp - last
        self._interval = self._interval or step
        missing = round(step / self._interval) - 1 if step > (1.0 + UNEVEN) * self._interval else 0
        if missing and (step * 1e-9 * abs(values[5]) > LONGEST_GAP * math.tau or len(self._waiting) < 2):
            self._restart()
            self._waiting = [(stamp, values)]
            return []
        found = []
        for k in range(1, missing + 1):
            fraction = k / (missing + 1)
            between = [one + fraction * (other - one) for one, other in zip(before, values, strict=True)]
            found += self._add(last + round(fraction * step), between)
        return found + self._add(stamp, values)

    def _add(self, stamp: int, values: list[float]) -> list[Place]:
        self._waiting.append((stamp, values))
        if len(self._waiting) < 3:
            return []
        (_, first), (middle, reading), (_, last) = self._waiting
        del self._waiting[0]
        kept = self._keep(middle, reading, 0.5 * (last[5] - first[5]))
        if self._filter is None:
            self._try_to_start(kept)
            return []
        acceleration = kept.acceleration + self._axial * kept.tilt + self._synchronous * kept.turn
        return [Place(kept.stamp, self._filter(acceleration), kept.spin, kept.speed)]

    def _keep(self, stamp: int, values: list[float], change: float) -> Kept:
        """Turn a reading into the frame of the hole, and keep it; `change` of the speed in an interval [rad/s]."""
        interval = self._interval * 1e-9
        force, swing, speed = complex(values[0], values[1]), complex(values[3], values[4]), values[5]
        turn = cmath.exp(1j * (self._spin + 0.5 * speed * interval))
        self._spin += speed * interval
        self.revolutions += abs(speed) * interval / math.tau
        arm = self._radius * complex(-speed * speed, change / interval)
        swing *= -1j * interval * turn  # of the tangent
        tilt = self._tilt + 0.5 * swing
        self._tilt += swing
        end = stamp + self._interval // 2
        kept = Kept(end, (force - arm) * turn, tilt, turn, values[2], self._spin, speed, self.revolutions)
        self._kept.append(kept)
        self.impacts.push(end * 1e-9, kept.acceleration, speed, interval)
        self.torsion.push(speed, values[0], interval)
        length = CALIBRATION if self._filter is None else MEMORY
        while self.revolutions - self._kept[0].revolutions > length:
            self._kept.popleft()
            self._whole = self._filter is None
        return kept

    def _try_to_start(self, newest: Kept) -> None:
        """Start the high pass once the string has turned steadily."""
        if self.revolutions < max(self._begin + CALIBRATION, self._due):
            return
        self._due = self.revolutions + 0.25
        rows = [*self._kept]
        begin, end = rows[0], rows[-1]
        seconds = (end.stamp - begin.stamp) * 1e-9
        usual = abs(end.spin - begin.spin) / max(seconds, 1e-9)
        half = int(np.searchsorted([row.revolutions for row in rows], newest.revolutions - 0.5 * CALIBRATION))
        times = (rows[half].stamp - begin.stamp) * 1e-9, (end.stamp - rows[half].stamp) * 1e-9
        uneven = abs(times[1] - times[0]) > STEADY * seconds
        slow = usual < math.tau * criteria.REST_ROTATION
        if slow or (uneven and self.revolutions - self._begin < PATIENCE) or len(rows) < 4 * CALIBRATION:
            return
        interval = self._interval * 1e-9
        self.corner = max(corner_for(self._clearance, self._noise, interval), SLOWEST * usual)
        self._filter = HighPass(self.corner, interval)
        self._axial = sum(row.axial for row in rows) / len(rows)
        record = self.record()
        fluctuation = record.acceleration - record.acceleration.mean()
        self._synchronous = -complex(np.mean(fluctuation * record.turn.conj()))
        for acceleration in (record.acceleration + self._synchronous * record.turn).tolist():
            self._filter(acceleration)

    def record(self) -> MotionRecord:
        """The last readings."""
        stamp, acceleration, tilt, turn, _, _, _, revolutions = zip(*self._kept, strict=True)
        total: ComplexArray = np.array(acceleration, np.complex128) + self._axial * np.array(tilt, np.complex128)
        return MotionRecord(
            np.array(stamp) * 1e-9, total, np.array(turn, np.complex128), np.array(revolutions), self._whole
        )
