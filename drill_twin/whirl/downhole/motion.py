# SPDX-License-Identifier: Apache-2.0
"""Lateral motion of a section from the readings of a sub, reading by reading.

Gyroscopes give attitude and spin. The lateral specific force, turned back by the spin, is the acceleration of the
centre line, plus the lever arm of the sensor (r Omega^2, r dOmega/dt) and gravity by the tilt of the section; both are
removed. A Butterworth high pass of fourth order, integrated twice, gives the position about its mean, for whirls well
above its corner. Its state at the start, which is that of a string that moves already, and what is constant in the
frame of the string (bias, bow) are fitted over the first revolutions at a steady speed, so that the position is small
there; constants and drifts in the frame of the hole (gravity in an inclined hole, turned by a bias of the gyroscope)
decay with the state.
"""

from __future__ import annotations

import cmath
import math
from collections import deque
from typing import NamedTuple

import numpy as np

from drill_twin.base.arrays import Array, ComplexArray
from drill_twin.whirl.criteria import Criteria

GRAVITY = 9.81
"""Gravity that tilt turns into lateral force, in the estimate of the noise [m/s^2]."""
SLOWEST = 0.06
"""Least corner of the high pass over the rotation [-]."""
CALIBRATION = 4.0
"""Length of the record over which state and constants are fitted [rev]."""
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
_NOISE_GAIN = 1.0 / (8.0 * math.sin(3.0 * math.pi / 8.0))  # of x^4 / (1 + x^8) over all x, by 2 pi
_DAMPING = math.cos(math.pi / 8.0), math.cos(3.0 * math.pi / 8.0)


class ToolNoise(NamedTuple):
    """Noise of the instruments of a sub: standard deviation of a sample."""

    force: float
    """Of the accelerometers [m/s^2]."""
    rate: float
    """Of the gyroscopes [rad/s]."""


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


class Record(NamedTuple):
    """The last readings as arrays, shape (n,)."""

    stamp: Array
    """Ends of the readings [s]."""
    acceleration: ComplexArray
    """Lateral acceleration in the frame of the hole, and constants [m/s^2]."""
    turn: ComplexArray
    """Unit vector of the spin."""
    revolutions: Array
    """[rev]"""


def corner_for(clearance: float, noise: ToolNoise, interval: float) -> float:
    """Lowest corner at which the noise of the position stays below the threshold of an onset [rad/s].

    The variance of the position is k S_f / a^3 + k g^2 S_w / a^5 on each axis, with S = sigma^2 T of accelerometers and
    gyroscopes, the corner a and k = 1 / (8 sin(3 pi / 8)): the integrals of the spectra behind the high pass.

    Args:
        clearance: Lateral clearance of the section [m].
        noise: Noise of the instruments.
        interval: Time between samples T [s].
    """
    criteria = Criteria()
    allowed = (criteria.onset_radius * clearance / criteria.false_alarm_factor) ** 2
    force, tilt = (_NOISE_GAIN * interval * part**2 / allowed for part in (noise.force, GRAVITY * noise.rate))
    roots = np.roots([1.0, 0.0, 0.0, -force, 0.0, -tilt])  # one is positive (Descartes)
    return float(max(roots.real[np.abs(roots.imag) <= 1e-9 * np.abs(roots)]))


class _HighPass:
    """Integral of the integral of means over intervals, at their ends, behind the high pass."""

    def __init__(self, corner: float, interval: float) -> None:
        from scipy.signal import cont2discrete

        low, high = ([1.0, 2.0 * damping * corner, corner**2] for damping in _DAMPING)
        numerator, denominator, _ = cont2discrete(([1.0, 0.0, 0.0], np.polymul(low, high)), interval, "zoh")
        self._b, self._a = numerator.ravel(), denominator
        self._coefficients = [*zip(self._b[1:].tolist(), self._a[1:].tolist(), strict=True)]
        self._state = [0j] * 4

    def start(self, acceleration: ComplexArray, turn: ComplexArray) -> complex:
        """Fit state and part along `turn` over a record whose position is small; return that part [m/s^2]."""
        from scipy.signal import lfilter

        silence = np.zeros(len(turn))
        free = [lfilter(self._b, self._a, silence, zi=unit)[0] for unit in np.eye(4)]
        forced, along = (lfilter(self._b, self._a, part) for part in (acceleration, turn))
        fitted = np.linalg.lstsq(np.stack([*free, along], -1), -forced, rcond=None)[0]
        _, state = lfilter(self._b, self._a, acceleration + fitted[4] * turn, zi=fitted[:4])
        self._state = state.tolist()
        return complex(fitted[4])

    def __call__(self, acceleration: complex) -> complex:
        """Position [m] after one more mean [m/s^2]; transposed direct form II, as scipy's `lfilter`."""
        one, two, three, four = self._state
        position = one
        (b1, a1), (b2, a2), (b3, a3), (b4, a4) = self._coefficients
        self._state = [
            b1 * acceleration - a1 * position + two,
            b2 * acceleration - a2 * position + three,
            b3 * acceleration - a3 * position + four,
            b4 * acceleration - a4 * position,
        ]
        return position


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
        self.gaps = 0
        """Gaps after which the fit began anew."""
        self._spin = self._revolutions = 0.0
        self._restart()

    def _restart(self) -> None:
        self._kept: deque[Kept] = deque(maxlen=MOST_KEPT)
        self._waiting: list[tuple[int, list[float]]] = []
        self._interval = 0
        self._tilt, self._axial, self._synchronous, self._due = 0j, GRAVITY, 0j, 0.0
        self._begin = self._revolutions
        self._filter: _HighPass | None = None
        self.corner = 0.0
        """Corner of the high pass [rad/s]: slower whirls are not seen; 0 before there is one."""

    @property
    def revolutions(self) -> float:
        """Revolutions so far [rev]."""
        return self._revolutions

    @property
    def started(self) -> bool:
        """True from the first place on."""
        return self._filter is not None

    def push(self, stamp: int, values: list[float]) -> list[Place]:
        """Add a reading, later than those before; return the places that it completes.

        The lever arm needs the acceleration of the spin: a place is that of the reading before.

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
            self.gaps += self.started
            self._restart()
            self._waiting = [(stamp, values)]
            return []
        found = []
        for k in range(1, missing + 1):
            share = k / (missing + 1)
            between = [one + share * (other - one) for one, other in zip(before, values, strict=True)]
            found += self._add(last + round(share * step), between)
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
        self._revolutions += abs(speed) * interval / math.tau
        arm = self._radius * complex(-speed * speed, change / interval)
        swing *= -1j * interval * turn  # of the tangent
        tilt = self._tilt + 0.5 * swing
        self._tilt += swing
        end = stamp + self._interval // 2
        kept = Kept(end, (force - arm) * turn, tilt, turn, values[2], self._spin, speed, self._revolutions)
        self._kept.append(kept)
        length = CALIBRATION if self._filter is None else MEMORY
        while self._revolutions - self._kept[0].revolutions > length:
            self._kept.popleft()
        return kept

    def _try_to_start(self, newest: Kept) -> None:
        """Start the high pass once the string has turned steadily."""
        if self._revolutions < max(self._begin + CALIBRATION, self._due):
            return
        self._due = self._revolutions + 0.25
        rows = [*self._kept]
        begin, end = rows[0], rows[-1]
        seconds = (end.stamp - begin.stamp) * 1e-9
        usual = abs(end.spin - begin.spin) / max(seconds, 1e-9)
        half = int(np.searchsorted([row.revolutions for row in rows], newest.revolutions - 0.5 * CALIBRATION))
        times = (rows[half].stamp - begin.stamp) * 1e-9, (end.stamp - rows[half].stamp) * 1e-9
        uneven = abs(times[1] - times[0]) > STEADY * seconds
        slow = usual < math.tau * Criteria().rest_rotation
        if slow or (uneven and self._revolutions - self._begin < PATIENCE) or len(rows) < 4 * CALIBRATION:
            return
        interval = self._interval * 1e-9
        self.corner = max(corner_for(self._clearance, self._noise, interval), SLOWEST * usual)
        self._filter = _HighPass(self.corner, interval)
        self._axial = sum(row.axial for row in rows) / len(rows)
        record = self.record()
        self._synchronous = self._filter.start(record.acceleration, record.turn)

    def record(self) -> Record:
        """The last readings."""
        stamp, acceleration, tilt, turn, _, _, _, revolutions = zip(*self._kept, strict=True)
        total: ComplexArray = np.array(acceleration, np.complex128) + self._axial * np.array(tilt, np.complex128)
        return Record(np.array(stamp) * 1e-9, total, np.array(turn, np.complex128), np.array(revolutions))
