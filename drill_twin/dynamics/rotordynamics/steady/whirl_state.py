# SPDX-License-Identifier: Apache-2.0
"""A steady whirl with its stability and its contact."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from drill_twin.core.arrays import ComplexArray
from drill_twin.dynamics.rotordynamics.steady.steady_whirl import MARGIN, SteadyWhirl, TurningEquations

ROLLING = 1e-2
"""Largest slip of a rolling string, over the speed of its surface."""


@dataclass(frozen=True, eq=False)
class WhirlState:
    """A steady whirl and its stability."""

    whirl: SteadyWhirl
    spectrum: ComplexArray
    """Eigenvalues in the turning frame [rad/s], fastest growth first."""
    slip: float
    """Slip of the contact point farthest from the axis, over the speed of the string's surface [-]; 0: it rolls."""
    touching: float
    """Share of the string's length that touches the wall [-]."""
    growth_change: float = math.nan
    """Change of `growth` on the last meshes, each twice as fine as the mesh before [1/s]; NaN: not known."""
    lost_at: int = 0
    """Elements of the finer mesh on which the state was not found again; 0: none."""

    @property
    def elements(self) -> int:
        """Elements of the mesh that it is a state of."""
        return len(self.whirl.u) - 1

    @property
    def is_locked(self) -> bool:
        """True if it turns with the string."""
        return self.whirl.omega == self.whirl.command.rotation

    @property
    def frequency(self) -> float:
        """Whirl frequency [Hz], positive in the sense of rotation."""
        return self.whirl.omega / math.tau

    @property
    def ratio(self) -> float:
        """Whirl speed over the rotation [-]."""
        return self.whirl.omega / self.whirl.command.rotation

    @property
    def growth(self) -> float:
        """Growth of the fastest disturbance [1/s]; negative: all decay."""
        return float(self.spectrum[0].real)

    @property
    def growth_frequency(self) -> float:
        """Frequency of that disturbance in the turning frame [Hz]; 0: it grows without oscillation."""
        return float(abs(self.spectrum[0].imag)) / math.tau

    @property
    def is_stable(self) -> bool:
        """True if every disturbance decays, to the accuracy of the computation."""
        return self.growth < MARGIN * abs(self.whirl.command.rotation)

    @property
    def verdict(self) -> str:
        """`stable` or `unstable`; `not determined` where finer meshes leave the sign of the growth open.

        The sign is open where meshes have changed the growth by more than its size, or where a mesh has lost the state.
        """
        if self.lost_at or not abs(self.growth) > self.growth_change:
            return "not determined"
        return "stable" if self.growth < 0.0 else "unstable"

    def stability(self) -> dict[str, Any]:
        """Growth [1/s] and how far finer meshes have moved it, in plain types; `stable` is None if not determined."""
        return {
            "stable": {"stable": True, "unstable": False}.get(self.verdict),
            "growth_per_s": self.growth,
            "growth_change_per_s": None if math.isnan(self.growth_change) else self.growth_change,
            "growth_frequency_hz": self.growth_frequency,
            "elements": self.elements,
            "lost_at_elements": self.lost_at or None,
        }

    @property
    def kind(self) -> str:
        """Sense of the whirl, and whether the string rolls; or that it is locked to the rotation."""
        if self.is_locked:
            return "locked"
        if abs(self.slip) < ROLLING:
            return "backward rolling" if self.ratio < 0.0 else "forward rolling"
        return "backward" if self.ratio < 0.0 else "forward"


def state_of(turning: TurningEquations, whirl: SteadyWhirl, *, is_locked: bool = False) -> WhirlState:
    """A steady whirl with its stability and contact; one locked to the rotation has a direction, and no zero
    eigenvalue.
    """
    model = turning.equations.model
    nodal_clearance = np.interp(model.rod.arc, model.places, model.wellbore.clearance)
    depth = whirl.radius - nodal_clearance
    deepest = int(np.argmax(depth))
    surface = float(np.interp(model.rod.arc[deepest], model.places, model.contact_radius)) * whirl.command.rotation
    slip = (whirl.omega * float(whirl.radius[deepest]) + surface) / surface
    ends = (depth[:-1] > 0.0).astype(float) + (depth[1:] > 0.0)
    touching = float(np.sum(np.diff(model.rod.arc) * 0.5 * ends) / model.rod.arc[-1])
    return WhirlState(whirl, turning.spectrum(whirl, is_locked=is_locked), slip, touching)
