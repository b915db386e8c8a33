# SPDX-License-Identifier: Apache-2.0
"""Correction of the lateral motion by downhole subs.

In a vertical hole a motion is as possible when it is turned about the axis. So the phase of a whirl is uniform, and no
linear filter finds it: each member is turned to the measured phase first. What is left is near-linear while the members
follow the rig, and the square-root filter corrects it: lateral motion, torsion and numbers.
"""

from collections.abc import Sequence

import numpy as np

from drill_twin.core.arrays import Array, ComplexArray
from drill_twin_studies.estimation.innovations import ChannelErrors
from drill_twin_studies.estimation.members import EstimatorMembers
from drill_twin_studies.estimation.square_root_filter import Correction, applied, correction
from drill_twin_studies.estimation.subs import lateral_velocity, replace_outliers, velocity_noise

_COHERENCE = 0.5
"""Correlation with the measured motion from which a member's phase is a phase of the same motion; not measured."""

_LOST = 2.0
"""Chi-square of a window above which the members have lost the motion; while they follow it, it is 0.01 to 0.5."""


class PhaseCorrection:
    """Corrects members by the lateral velocity of s subs.

    Attributes:
        predicted: Velocities of the last window, x and y of each sub, shape (N, 2 s, S), turned.
        measured: Velocities of the rig, shape (2 s, S); NaN where there were no readings.
        errors: Errors of the velocities.
        chi_square: Mean square of measured less predicted over the predicted value, in the last window with readings.
    """

    def __init__(self, members: EstimatorMembers, share: float) -> None:
        pace, subs = members.pace, members.subs
        floor = np.tile([velocity_noise(sub, pace.window) for sub in subs], 2)
        self.errors = ChannelErrors(2 * len(subs), share, floor)
        self.predicted: Array = np.zeros((len(members), 2 * len(subs), pace.samples))
        self.measured: Array = np.full(self.predicted.shape[1:], np.nan)
        self.chi_square = 0.0

    @property
    def lost(self) -> bool:
        """True where the members have lost the motion: the window then tells motion, and nothing of numbers."""
        return self.chi_square > _LOST

    def __call__(
        self, members: EstimatorMembers, predicted: Array, measured: Array, found: Sequence[Correction]
    ) -> list[Correction]:
        """Turn the members, find the correction of their lateral motion, and apply it.

        Args:
            members: Members at the end of the window.
            predicted: Readings of the subs, shape (N, F, s, 6).
            measured: Readings of the rig's subs, shape (s, F, 6); NaN for a sub without readings.
            found: Corrections by the other channels, which come first.
        """
        period, samples = members.pace.period, members.pace.samples
        rig = lateral_velocity(replace_outliers(measured, predicted), period, samples)
        own = lateral_velocity(predicted.swapaxes(1, 2), period, samples)
        lateral = members.lateral
        motion = lateral.read(members.twins)
        if lateral.turns_freely:
            turn = turns(own, rig)
            own, motion = own * turn[:, None, None], motion * turn[:, None, None, None]
        self.predicted = np.concatenate((own.real, own.imag), axis=1)
        self.measured = self.errors.screen(self.predicted, np.concatenate((rig.real, rig.imag)))
        if not np.isfinite(self.measured).any():
            return []
        variance = self.predicted.var(axis=0, ddof=1) + self.errors.stated[:, None] ** 2
        self.chi_square = float(np.nanmean((self.measured - self.predicted.mean(axis=0)) ** 2 / variance))
        scaled = applied(found, self.predicted) / self.errors.deviation[:, None]
        target = (self.measured / self.errors.deviation[:, None]).ravel()
        new = [correction(scaled.reshape(len(scaled), -1), target, np.ones(target.size))]
        lateral.write(members.twins, applied(new, motion.view(float)).view(complex))
        corrected = applied([*found, *new], self.predicted)
        self.errors.learn(self.measured, self.predicted.mean(axis=0), corrected.mean(axis=0))
        return new


def turns(predicted: ComplexArray, measured: ComplexArray) -> ComplexArray:
    """Unit numbers that turn the motion of each member to the measured phase, shape (N,); 1 for another motion.

    Args:
        predicted: Lateral velocities, shape (N, s, S).
        measured: Lateral velocities of the rig, shape (s, S); NaN where missing.
    """
    known = np.isfinite(measured)
    along = (predicted[:, known].conj() * measured[known]).sum(axis=1)
    size = np.sqrt((np.abs(predicted[:, known]) ** 2).sum(axis=1) * (np.abs(measured[known]) ** 2).sum())
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(np.abs(along) > _COHERENCE * size, along / np.abs(along), 1.0)
