# SPDX-License-Identifier: Apache-2.0
"""Restarts after a jump, to find the number that, changed alone, makes the members do what was measured since.

Regression on the members does not tell the number: torque is no linear function of friction, and all numbers that act
on one channel correlate with it. So a few members go some windows back and follow the rig again with the numbers that
they had: first as they were, then with another value of one number in each member, then with other values of all
numbers that the channel tells. The values close in on the best value.

Members that have lost a motion are wrong, and too much alike. Followed from some windows back, with the numbers that
they had and without correction, they differ by as much as the motion can. If such members explain what was measured, no
number has jumped.
"""

from collections import deque
from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import NamedTuple

import numpy as np
from scipy import special

from drill_twin.core.arrays import Array, Mask
from drill_twin.core.errors import DrillTwinError, RunError
from drill_twin_studies.estimation.estimate import FilterWindow
from drill_twin_studies.estimation.innovations import rms
from drill_twin_studies.estimation.members import EstimatorMembers
from drill_twin_studies.fitting.sampling import sobol
from drill_twin_studies.goodness import noise_of

_BACK = 6, 4, 2
"""Windows to go back: friction at rest shows only when the bit breaks off, some windows after the friction has changed;
not measured."""
_TRIALS, _WIDTHS = 16, (0.25, 0.06)
"""Values that are tried at a time, and the parts of the prior about the last best value in which they lie; not
measured."""
_EXPLAINS = 1.0
"""Rms of measured less computed over the stated error, up to which a restart explains what was measured. Restarts with
the number that had jumped reached 0.4 to 0.5; after a jump of the string's stiffness all restarts had 1.5 to 3.3."""

_OVER_NOISE = 1.6
"""Rms of measured less computed over the noise of what was measured, which counts where the noise is larger; not
measured."""
_LOST = 2.0
"""Normalised innovation of members with unchanged numbers, up to which these members explain what was measured. The
innovation was 0.3 to 0.8 in five of six cases where the motion was lost, and 4 to 13 after jumps of load and of wall
friction."""
_GAIN = 0.85
"""Misfit of all numbers together, as new rock changes them, over the misfit of the best number alone, up to which all
together explain what was measured: more numbers always explain more."""


class _Window(NamedTuple):
    """A window: numbers and states of the members at its start, the window, and what was measured, shape (C, S)."""

    normal: Array
    states: Sequence[Mapping[str, Array]]
    window: FilterWindow
    measured: Array


class Restart(NamedTuple):
    """Change of numbers that explains what was measured; of no number, if the members had lost the motion.

    Attributes:
        windows: Windows to go back.
        chosen: Numbers that have changed, shape (d,).
        centre: Places of all numbers in the prior, from 0 to 1, shape (d,); only the chosen numbers' places are new.
        misfit: Rms of measured less computed over the stated error, of the best member.
        normalised: Rms of measured less the mean of the members, over what members and stated error predict, in the
            channel where it is largest.
    """

    windows: int
    chosen: Mask
    centre: Array
    misfit: float
    normalised: float


class Restarts:
    """The last windows of members, and restarts from their starts."""

    def __init__(self, members: EstimatorMembers, channels: Sequence[str], few: float) -> None:
        """Begin.

        Args:
            members: Members of the ensemble.
            channels: Names of the channels of the surface.
            few: Factor by which the spread of the members may be too small.
        """
        self._members, self._channels, self._few = members, list(channels), few
        self._past: deque[_Window] = deque(maxlen=max(_BACK))

    def held(self, windows: int) -> Array:
        """Numbers of the members before the last windows, shape (N, d)."""
        return self._past[-min(windows, len(self._past))].normal

    def begin(self, window: FilterWindow) -> None:
        """Begin a window, before the members are advanced over it."""
        members = self._members
        states = [members.checkpoint(number) for number in range(len(members))]
        self._past.append(_Window(members.normal.copy(), states, window, np.empty(0)))

    def end(self, measured: Array) -> None:
        """End the window with what was measured, shape (C, S), the channels of the surface first."""
        self._past[-1] = self._past[-1]._replace(measured=measured[: len(self._channels)])

    def found(self, told: Mask, errors: Array, judged: int) -> Restart | None:
        """Change of numbers that explains the last windows, of none, one or all of them; None if no change explains
        them.

        Args:
            told: Numbers that the odd channel tells, shape (d,).
            errors: Stated errors of a sample of each channel, shape (C,).
            judged: Number of the last windows, which show the jump, and are compared.
        """
        back = [windows for windows in _BACK if windows >= judged]
        unchanged = [self._tried(start, np.zeros_like(told), None, 1.0, errors, judged) for start in back]
        nearest = min(unchanged, key=lambda one: one.normalised)
        if nearest.normalised < _LOST:
            return nearest
        alone = [np.arange(told.size) == number for number in np.flatnonzero(told)]
        best = None
        for sets in (alone, [told] if len(alone) > 1 else []):
            tried = [self._tried(start, each, None, 1.0, errors, judged) for start in back for each in sets]
            if not tried:
                continue
            found = min(tried, key=lambda one: one.misfit)
            for width in _WIDTHS:
                again = self._tried(found.windows, found.chosen, found.centre, width, errors, judged)
                found = min(found, again, key=lambda one: one.misfit)
            if best is None or found.misfit < _GAIN * best.misfit:
                best = found
        return best if best is not None and best.misfit < self._limit(errors) else None

    def _limit(self, errors: Array) -> float:
        """Misfit up to which a restart explains what was measured, whose noise may be as large as the stated error."""
        measured = np.concatenate([window.measured for window in self._past], axis=1)
        noise = np.array([noise_of(row) for row in measured]) / errors[: len(measured)]
        return max(_EXPLAINS, _OVER_NOISE * float(np.sqrt(np.mean(noise**2))))

    def follow(self, restart: Restart) -> None:
        """Set all members back, with the numbers that have changed drawn about their new values, and follow again.

        Raises:
            RunError: No member could be followed.
        """
        past = list(self._past)[-restart.windows :]
        count = len(self._members)
        self._members.normal = self._drawn(past[0].normal, restart.chosen, restart.centre, _WIDTHS[0], count)
        failed = []
        for number in range(count):
            try:
                self._members.replay(number, past[0].states[number], [each.window for each in past])
            except DrillTwinError:
                failed.append(number)
        sound = [number for number in range(count) if number not in failed]
        if not sound:
            raise RunError("no member could be followed after a jump")
        for number in failed:
            self._members.copy(sound[number % len(sound)], number)

    def _tried(
        self, back: int, chosen: Mask, centre: Array | None, width: float, errors: Array, judged: int
    ) -> Restart:
        """Best of some values of the chosen numbers, in a part of the prior about a centre."""
        members, past = self._members, list(self._past)[-back:]
        count = min(_TRIALS, len(members))
        who = np.linspace(0, len(members) - 1, count).round().astype(int)
        normal, states = members.normal, [members.checkpoint(number) for number in who]
        members.normal = members.normal.copy()
        members.normal[who] = values = self._drawn(past[0].normal[who], chosen, centre, width, count)
        stated = errors[: len(self._channels), None]
        measured = np.array([window.measured for window in past[-judged:]])
        computed: Array = np.full((count, *measured.shape), np.nan)
        for row, number in zip(computed, who.tolist(), strict=True):
            with suppress(DrillTwinError):
                rows = members.replay(number, past[0].states[number], [each.window for each in past])
                row[:] = [[each[name] for name in self._channels] for each in rows[-judged:]]
        members.normal = normal
        for number, state in zip(who.tolist(), states, strict=True):
            members.replay(number, state, [])  # as it was, with its own numbers
        off = measured - computed
        misfits = np.nan_to_num(rms((off / stated).reshape(count, -1) ** 2), nan=np.inf)
        best, normalised = int(np.argmin(misfits)), np.inf
        sound = np.isfinite(misfits)
        if 2 * sound.sum() >= count:
            variance = (self._few * computed[sound].std(axis=0, ddof=1)) ** 2 + stated**2
            square = off[sound].mean(axis=0) ** 2 / variance
            normalised = float(np.nanmax(rms(square.swapaxes(0, 1).reshape(len(stated), -1))))
        return Restart(back, chosen, special.ndtr(values[best]), float(misfits[best]), normalised)

    def _drawn(self, normal: Array, chosen: Mask, centre: Array | None, width: float, count: int) -> Array:
        """Numbers, shape (count, d), with the chosen ones spread over a part of the prior."""
        if not chosen.any():
            return normal.copy()
        cube = sobol(int(chosen.sum()), count, 1)
        middle = 0.5 if centre is None else np.clip(centre[chosen], 0.5 * width, 1.0 - 0.5 * width)
        drawn = normal.copy()
        drawn[:, chosen] = special.ndtri(np.clip(middle + width * (cube - 0.5), 1e-3, 1.0 - 1e-3))
        return drawn
