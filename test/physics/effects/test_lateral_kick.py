# SPDX-License-Identifier: Apache-2.0
"""A kick bends the string that a run begins with, on the axis or already bent, and changes no axial force of it."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from drill_twin.core.errors import RunError, StoppedError
from drill_twin.dynamics.twin.dynamics import Dynamics
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.physics.effects import lateral_kick
from drill_twin.physics.effects.lateral_kick import LateralKick
from drill_twin.physics.model.mesh import Tube, build_rod
from drill_twin.scene import load_scene
from drill_twin.scene.set_points.command import Command

LENGTH, ELEMENTS = 5.0, 40
ROD = build_rod([Tube(LENGTH, 0.016, 0.0, 2.3e9, 0.35, 1150.0)], ELEMENTS)
BENT = {"rig.start": "equilibrium", "rig.weight_on_bit.value": "60 N", "numerics.elements": "16"}


def bent(height: float, turned: float, strain: float) -> tuple[np.ndarray, np.ndarray]:
    """Rows of a half wave of a height [m] in a direction [rad] and of one axial strain, and their velocities, 0."""
    u = np.zeros((ELEMENTS + 1, 7))
    number, g = np.pi / LENGTH, 1.0 + strain
    fine = np.linspace(0.0, LENGTH, 100_001)
    off, slope = height * np.sin(number * ROD.arc), height * number * np.cos(number * ROD.arc)
    u[:, 0], u[:, 1] = off * np.cos(turned), off * np.sin(turned)
    u[:, 3], u[:, 4] = slope * np.cos(turned), slope * np.sin(turned)
    u[:, 5] = np.sqrt(g**2 - slope**2)
    along = np.sqrt(g**2 - (height * number * np.cos(number * fine)) ** 2)
    below = np.concatenate([[0.0], np.cumsum(0.5 * (along[1:] + along[:-1]) * np.diff(fine))])
    u[:, 2] = np.interp(ROD.arc, fine, below) - below[-1]
    return u, np.zeros_like(u)


def strains(u: np.ndarray) -> np.ndarray:
    """At the nodes and at the inner samples, as the kernel has them."""
    nodal = np.stack([u[:-1, 0:3], u[:-1, 3:6], u[1:, 0:3], u[1:, 3:6]], 1)
    inner = np.einsum("ei,eic->ec", ROD.inner, nodal)
    return np.concatenate([np.linalg.norm(u[:, 3:6], axis=1), np.linalg.norm(inner, axis=1)]) - 1.0


@pytest.mark.parametrize("shape", ["half_wave", "hump"])
@pytest.mark.parametrize("offset", [0.01, -0.03, 0.3])
@pytest.mark.parametrize(("height", "turned", "strain"), [(0.0, 0.0, 0.0), (0.02, 0.0, -1e-4), (0.05, 2.0, 2e-4),
                                                         (0.4, 1.0, -1e-3)])  # fmt: skip
def test_the_axial_strain_stays(shape: Any, offset: float, height: float, turned: float, strain: float) -> None:
    u, v = bent(height, turned, strain)
    before, top = u.copy(), u[-1].copy()
    model: Any = SimpleNamespace(rod=ROD, string_length=LENGTH)
    lateral_kick.initial_state(LateralKick(velocity=0.0, offset=offset, shape=shape), model, u, v)
    curved = (np.pi / LENGTH * (height + abs(offset))) ** 4  # of the shape functions between the nodes
    assert strains(u) == pytest.approx(strain, abs=1e-9 + 1e-3 * curved)
    assert u[-1, 2] == pytest.approx(top[2], abs=1e-12), "the top stays where it is"
    height_at_middle = u[ELEMENTS // 2, 0] - before[ELEMENTS // 2, 0]
    assert height_at_middle == pytest.approx(offset)
    assert u[:, [1, 4, 6]] == pytest.approx(before[:, [1, 4, 6]])
    assert not v.any()


def test_a_string_in_equilibrium_under_60_newton_keeps_its_axial_force() -> None:
    """Before, a string bent by 82 mm began with 5,417 N."""
    kick = {"effects.lateral_kick": "{velocity: 0 m/s, offset: 20 mm, shape: hump}"}
    plain, kicked = (Dynamics(load_scene("pa6_bench", overrides=BENT | more)) for more in ({}, kick))
    force = [
        dynamics.rod.axial[0] * (np.linalg.norm(dynamics.unknowns[0][:, 3:6], axis=1) - 1.0)
        for dynamics in (plain, kicked)
    ]
    assert force[0].min() == pytest.approx(-60.0, rel=0.01)
    assert force[1] == pytest.approx(force[0], abs=0.1)
    moved = kicked.unknowns[0][:, 0] - plain.unknowns[0][:, 0]
    assert moved.max() == pytest.approx(0.02), "the search for the equilibrium has not seen the kick"


def test_what_cannot_be_bent_is_refused() -> None:
    u, v = bent(1.4, 0.0, 0.0)
    model: Any = SimpleNamespace(rod=ROD, string_length=LENGTH)
    with pytest.raises(RunError, match=r"effects\.lateral_kick\.offset: expected less than what bends the string"):
        lateral_kick.initial_state(LateralKick(velocity=0.0, offset=0.7), model, u, v)


def test_a_kick_into_the_wall_is_said_to_be_the_cause() -> None:
    kick = {"effects.lateral_kick": "{velocity: 0 m/s, offset: 80 mm, shape: hump}"}
    twin = Twin(load_scene("pa6_bench", overrides=BENT | kick))
    with pytest.raises(StoppedError, match=r"deep in the wall.*Try a smaller effects\.lateral_kick\.offset"):
        twin.advance(Command(60.0, 0.0), 0.01)
