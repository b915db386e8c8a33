# SPDX-License-Identifier: Apache-2.0
"""Initial lateral velocity or displacement: a repeatable impulse, or a start on the wall."""

from collections.abc import Iterator
from typing import Annotated, Any, Literal

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.errors import RunError
from drill_twin.core.units import Length, Speed, Within
from drill_twin.physics.effects.config import EffectConfig, Problem
from drill_twin.physics.model import DiscreteModel, element_unknowns, locate

STEEPEST = 0.5
"""Largest initial slope [-]."""


class LateralKick(EffectConfig):
    """Initial velocity, and initial displacement, in x."""

    energy_class = "kept"
    disabled_for_static = ("velocity", "offset")

    velocity: Annotated[Speed, Within(at_least="-100 m/s", at_most="100 m/s", reason="no string is kicked harder")]
    """Velocity at mid-span at time zero [m/s]."""
    offset: Annotated[Length, Within(at_least="-10 m", at_most="10 m", reason="the widest hole")] = 0.0
    """Displacement at mid-span at time zero [m], by bending alone: the axial strain of `rig.start` stays. Beyond the
    clearance the string starts in contact. In a straight hole only."""
    shape: Literal["half_wave", "hump"] = "half_wave"
    """Shape of both. `half_wave`: one half sine over the length; `hump`: its square, for clamped ends."""

    def check_against(self, scene: Any) -> Iterator[Problem]:
        """Yield an offset beyond the hole, above the largest slope, or in a curved hole."""
        hole = scene.hole
        most = min(hole.radius, STEEPEST * scene.length / np.pi)
        if self.offset != 0.0 and (abs(self.offset) > most or hole.survey):
            found = "one beside a survey" if hole.survey else f"{self.offset:.6g} m"
            yield (
                ("offset",),
                (
                    f"expected at most the radius of a straight hole and a slope of {STEEPEST:g} ({most:.6g} m), "
                    f"found {found}"
                ),
            )


def initial_state(block: LateralKick, model: DiscreteModel, u: Array, v: Array) -> None:
    """Set the initial velocities of r and r' along x, and their displacements.

    Raises:
        RunError: The string of `rig.start` cannot be bent so far.
    """
    arc = model.rod.arc
    height, slope = wave(block, model, arc)
    v[:, 0] += block.velocity * height
    v[:, 3] += block.velocity * slope
    if block.offset == 0.0:
        return
    fine = np.linspace(0.0, model.string_length, 10_001)
    element, _, shapes = locate(model.rod, fine)
    tangents = np.einsum("pi,pic->pc", shapes[:, 1], element_unknowns(u)[element])
    along = _bent(tangents, block.offset * wave(block, model, fine)[1])
    u[:, 5] = _bent(u[:, 3:6], block.offset * slope)
    u[:, 0] += block.offset * height
    u[:, 3] += block.offset * slope
    if np.isnan(along).any() or np.isnan(u[:, 5]).any():
        raise RunError(
            "effects.lateral_kick.offset: expected less than what bends the string of rig.start by a right angle, "
            f"found {block.offset:.6g} m"
        )
    # a bent string of the same length is shorter along z: every point rises by the shortening above it
    lost = tangents[:, 2] - along
    below = np.concatenate([[0.0], np.cumsum(0.5 * (lost[1:] + lost[:-1]) * np.diff(fine))])
    u[:, 2] += below[-1] - np.interp(arc, fine, below)


def _bent(tangents: Array, slope: Array) -> Array:
    """Component z that keeps the size of r', shape (p, 3), with a slope [-] added in x [-], shape (p,); NaN: none."""
    square = tangents[:, 2] ** 2 + tangents[:, 0] ** 2 - (tangents[:, 0] + slope) ** 2
    return np.asarray(np.sqrt(np.where(square > 0.0, square, np.nan)))


def wave(block: LateralKick, model: DiscreteModel, arc: Array) -> tuple[Array, Array]:
    """Shape, 1 at mid-span, and its derivative by the arc length [1/m], shape (m,) each."""
    number = np.pi / model.string_length
    if block.shape == "half_wave":
        return np.sin(number * arc), number * np.cos(number * arc)
    return np.sin(number * arc) ** 2, number * np.sin(2.0 * number * arc)
