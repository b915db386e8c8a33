# SPDX-License-Identifier: Apache-2.0
"""Truth of a record, without a threshold.

**Whirl.** A motion whirls if it was prescribed as one: an orbit that goes round, whose smaller half axis is at least
0.45 of the larger one, or two such orbits, or an irregular path. A swing (half axes 0 to 0.15), a forced response, a
free vibration that dies and single shocks do not whirl. Ellipses between are neither: their records show only how often
a detector calls them whirl. In a simulated run a motion whirls if it grows where a linear mode grows, or goes on going
round for most of the run (`simulated`).

**Onset.** A growing orbit has no moment at which it begins. So the truth is its amplitude over time A(t), over the
clearance: the root of the summed squares of its circular parts, as prescribed; in a simulated run the amplitude of the
whole string along its linear growth. A detector says that a whirl begins when it exceeds a level, and names the level.
The true onset for that detector is the first time at which A exceeds that level; A grows without a break. The level is
the detector's own statement, taken at its word; no number of the truth is a copy of it.

**State.** The state that was prescribed, from the onset on, at each mark and for the string. Motions are prescribed
far from the borders between states, so that no border enters: what creeps has at most 0.3 of the pace of rolling, what
rolls 0.9 to 1.1 of it; a plane has shapes whose phases differ by at most 0.3 rad, a helix spreads over half a turn or
more. Where a motion changes to another, or an orbit still grows to the wall, no state is true, and none scored.
A swing, and a forced response, has its state while its own amplitude exceeds the same level.

**Numbers that remain**, chosen by hand: 0.15 and 0.45 (half axes), 0.3 and 0.9 to 1.1 (rolling), 0.3 rad and half a
turn (shapes), and those of `simulated`. None is a border at which a record lies.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drill_twin.core.arrays import Array
from drill_twin.whirl import MarkInfo

PER_TURN = 8
"""Times of the truth in a revolution."""
FIXED = "rotation about a fixed axis"
SWING, SYNCHRONOUS, CREEP, IMPACTS = (
    "swinging in a plane", "synchronous whirl", "creeping along the wall", "striking the wall",
)  # fmt: skip
FORWARD, BACKWARD, ROLLING = "forward whirl", "backward whirl", "rolling along the wall"
BENDING, SPIRAL, IRREGULAR = "second bending", "spiral", "irregular"
WHIRLS = {SYNCHRONOUS, FORWARD, BACKWARD, ROLLING, BENDING, SPIRAL, IRREGULAR, CREEP, IMPACTS}
NEW = (SWING, CREEP, IMPACTS)
"""States that the detector of the first score does not name."""


@dataclass(frozen=True, eq=False)
class Truth:
    """Truth of a record; s times, m marks."""

    time: Array
    """Times [s], as the stamps count, shape (s,)."""
    turns: Array
    """Revolutions at these times, shape (s,)."""
    amplitude: Array
    """Amplitude of the whirl of each mark over its clearance, shape (s, m); 0 for a motion that does not whirl."""
    moving: Array
    """The same of a motion that has a state without a whirl, or with a synchronous one, shape (s, m)."""
    motion: tuple[str, ...]
    """State of the string while it moves so; empty where none is true."""
    marks: tuple[tuple[str, ...], ...]
    """State of each mark while it moves so."""
    ratio: float | None = None
    """Whirl ratio of the larger orbit; None where the motion has none, or changes to another."""
    scored: bool = True
    """False where it is not defined whether the motion whirls."""
    dated: bool = True
    """False where the time of the onset is not known."""
    synchronous: bool = False
    """True where a synchronous onset is right, and any other is not."""

    def began(self, level: float, mark: int | None = None) -> float | None:
        """Time [s] at which the whirl of a mark, or of any, exceeds a level over the clearance; None if it does not."""
        size = self.amplitude.max(axis=1) if mark is None else self.amplitude[:, mark]
        i = int(np.argmax(size > level)) - 1
        if not size[i + 1] > level:
            return None
        if i < 0:
            return float(self.time[0])
        low, high = (math.log(max(value, 1e-9)) for value in size[i : i + 2])
        share = (math.log(level) - low) / (high - low)
        return float(self.time[i] + share * (self.time[i + 1] - self.time[i]))

    def string_states(self, level: float) -> list[str]:
        """State of the string at each time, for a level over the clearance."""
        return self._states(self.motion, level, None)

    def mark_states(self, level: float, mark: int) -> list[str]:
        """State of a mark at each time."""
        return self._states(self.marks[mark], level, mark)

    def _states(self, names: Sequence[str], level: float, mark: int | None) -> list[str]:
        began = self.began(level, mark)
        moving = self.moving.max(axis=1) if mark is None else self.moving[:, mark]
        found = []
        for time, size, name in zip(self.time.tolist(), moving.tolist(), names, strict=True):
            whirls = began is not None and time >= began
            found.append(name if whirls or size > level or not name else FIXED)
        return found


@dataclass(frozen=True, eq=False)
class FrozenRecord:
    """Measured signals and what is true of them; T samples, m marks."""

    kind: str
    """Letter of the kind (`records.KINDS`)."""
    name: str
    marks: tuple[MarkInfo, ...]
    stamp: NDArray[np.int64]
    """Stamps [ns], shape (T,)."""
    position: Array
    """Marked points [m], shape (T, m, 2); nan where not seen."""
    spin: Array | None
    """Spin at the marks [rad], shape (T, m); None where it is not measured."""
    top_speed: Array
    """Speed of the top drive [rad/s], shape (T,)."""
    truth: Truth


def digest(records: Sequence[FrozenRecord]) -> str:
    """Digest of records and truths to four digits, the same on any machine."""
    found = hashlib.sha256()
    for record in records:
        truth = record.truth
        numbers = [
            record.stamp.size, record.top_speed.mean(), np.nanmean(np.abs(record.position)), truth.amplitude.mean(),
            truth.moving.mean(), truth.ratio or 0.0, *(truth.began(level) or -1.0 for level in (0.03, 0.07)),
        ]  # fmt: skip
        states = sorted({*truth.motion, *(name for mark in truth.marks for name in mark)})
        found.update(repr((record.name, *(f"{number:.3e}" for number in numbers), *states)).encode())
    return found.hexdigest()[:16]
