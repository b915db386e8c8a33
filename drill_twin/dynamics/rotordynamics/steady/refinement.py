# SPDX-License-Identifier: Apache-2.0
"""Steady whirls on finer meshes: how much of a state is the rod's, and how much its mesh's.

Contact is sampled at two points of each element. Where the string touches the wall along a part of its length, this
moves the growth of a disturbance far more than the whirl speed, by its sign too.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from drill_twin.dynamics.audit.energy import rows_at
from drill_twin.dynamics.rotordynamics.equations import EquationsOfMotion, meshed
from drill_twin.dynamics.rotordynamics.steady.imperfections import locked_near
from drill_twin.dynamics.rotordynamics.steady.steady_whirl import MARGIN, TurningEquations
from drill_twin.dynamics.rotordynamics.steady.whirl_state import WhirlState, state_of
from drill_twin.dynamics.rotordynamics.steady.whirl_states import is_new, state_near
from drill_twin.physics.model import Rod
from drill_twin.scene import Scene

LARGEST_CHANGE, DOUBLINGS = 0.03, 2
"""Changes of a growth on meshes twice as fine, over itself, from which no finer mesh is tried, and how many of them."""
MOST_UNKNOWNS, MOST_ONCE = 520, 1200
"""Size of the finest mesh: eigenvalues of full matrices take half a second there, ten seconds at the size up to which
one mesh twice as fine is tried anyway."""
SAME_RATIO, SAME_RADIUS = 0.01, 0.1
"""Largest changes of whirl speed over rotation, and of radii over the clearance, of the same state on two meshes."""


def refined(scene: Scene, state: WhirlState) -> WhirlState:
    """A state on meshes twice as fine each, until two meshes in turn change its growth by at most 3 %.

    Convergence is not monotone: parts of the string come to touch the wall, or leave it, as the mesh moves its points.
    So the larger of the last two changes is kept.

    Args:
        scene: Scene of the state; `numerics.elements` may differ.
        state: A steady whirl, or a state that is locked to the rotation.

    Returns:
        The state on the finest mesh, with `growth_change`; with `lost_at` where it was not found again.
    """
    least, changes = MARGIN * abs(state.whirl.command.rotation), list[float]()
    equations = EquationsOfMotion(meshed(scene, state.elements))
    while True:
        rod = equations.model.rod
        equations = EquationsOfMotion(meshed(scene, 2 * state.elements))
        if equations.unknowns > (MOST_UNKNOWNS if changes else MOST_ONCE):
            return state
        found = _again(equations, state, rod)
        if found is None:
            return replace(state, lost_at=equations.model.rod.length.size)
        changes = [*changes, abs(found.growth - state.growth)][-DOUBLINGS:]
        state = replace(found, growth_change=max(changes))
        if len(changes) == DOUBLINGS and max(changes) <= max(LARGEST_CHANGE * abs(state.growth), least):
            return state


def refined_states(scene: Scene, states: Sequence[WhirlState]) -> tuple[WhirlState, ...]:
    """States by `refined`; two that are one on the finer mesh are given once."""
    found: list[WhirlState] = []
    for state in states:
        fine = refined(scene, state)
        same_mesh = [one.whirl for one in found if one.elements == fine.elements]
        if fine.kind == "locked" or is_new(fine.whirl, same_mesh, float(scene.least_clearance)):
            found.append(fine)
    return tuple(sorted(found, key=lambda one: -one.whirl.omega))


def _again(equations: EquationsOfMotion, state: WhirlState, rod: Rod) -> WhirlState | None:
    """The same state on another mesh; None if Newton's method finds none, or another."""
    turning, (u, _) = TurningEquations(equations), equations.on_axis(state.whirl.command)
    u[:, equations.columns] = rows_at(rod, state.whirl.u, equations.model.rod.arc)[:, equations.columns]
    guess = replace(state.whirl, u=u)
    if state.is_locked:
        found = locked_near(turning, guess)
    else:
        whirl = turning.newton(guess)
        found = state_of(turning, whirl) if whirl is not None else state_near(equations, guess)
    if found is None or abs(found.ratio - state.ratio) > SAME_RATIO:
        return None
    apart = np.abs(np.interp(rod.arc, equations.model.rod.arc, found.whirl.radius) - state.whirl.radius).max()
    return found if apart < SAME_RADIUS * turning.clearance else None
