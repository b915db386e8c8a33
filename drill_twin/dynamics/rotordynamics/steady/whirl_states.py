# SPDX-License-Identifier: Apache-2.0
"""Steady whirl states under one command: all states that the search finds, each with its stability.

One of the states is the initial state of `rig.start: whirl-state`.
"""

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.errors import RunError, SceneError
from drill_twin.dynamics.discretisation.kernel_arguments import LATERAL
from drill_twin.dynamics.rotordynamics.equations import EquationsOfMotion, meshed, without
from drill_twin.dynamics.rotordynamics.modes import is_vertical
from drill_twin.dynamics.rotordynamics.steady.shape_search import (
    ACROSS,
    SOFT_CREEP,
    ShapeSearch,
    set_creep,
    slow_whirls,
    stiffen_friction,
)
from drill_twin.dynamics.rotordynamics.steady.steady_whirl import SteadyWhirl, TurningEquations, deflation
from drill_twin.dynamics.rotordynamics.steady.whirl_state import WhirlState, state_of
from drill_twin.physics.model import DiscreteModel
from drill_twin.scene import Scene
from drill_twin.scene.set_points.command import Command

RANDOM_STARTS = 2
SEED = 1
SAME_SPEED, SAME_SHAPE = 1e-4, 1e-3
"""Two states are one if their whirl speeds differ by less than this share of the rotation, and their radii by less than
this share of the clearance."""
DEFLATIONS = 4
"""Most steady whirls taken from one first guess."""
MOST_UNKNOWNS = 1000
SPATIAL_EFFECTS = ("stretch", "torsion")
"""Effects that the lateral form does without."""
SAME_ROLLING = 0.01
"""Parts of a string roll at one whirl speed if theirs differ by less than this share."""


def check_whirls(equations: EquationsOfMotion, command: Command) -> None:
    """Raise where no steady whirl exists.

    Raises:
        SceneError: An inclined or curved hole, no wall, no rotation, or too fine a mesh.
    """
    name = equations.scene.name
    if not is_vertical(equations):
        raise SceneError(
            f"{name}: expected a straight vertical hole, found an inclined or curved one, in which no steady whirl "
            "exists: a string that whirls meets another force in every direction; run it (drill-twin run)"
        )
    if hasattr(equations.parameters, "bit_regenerative"):
        raise SceneError(
            f"{name}: expected a bit whose rock has no memory, found bit_regenerative; --without bit_regenerative "
            "leaves it out, drill-twin modes takes its delay into account"
        )
    if not hasattr(equations.parameters, "wall"):
        raise SceneError(f"{name}: expected the effect wall, found none: nothing limits a whirl; see drill-twin modes")
    if equations.unknowns > MOST_UNKNOWNS:
        raise SceneError(
            f"{name}: expected at most {MOST_UNKNOWNS} unknowns, as stability needs eigenvalues of full matrices, "
            f"found {equations.unknowns}; take fewer elements (--set numerics.elements=100)"
        )
    if not all(support.is_isotropic for support in equations.scene.string.supports):
        raise SceneError(
            f"{name}: expected supports that act alike in all directions, found two stiffnesses or dampings: no whirl "
            "is steady then; see drill-twin modes, or run it"
        )
    if command.rotation == 0.0:
        raise SceneError(f"{name}: expected a rotation other than 0, found none; give a speed, such as --rpm 120")


def whirl_states(
    equations: EquationsOfMotion,
    command: Command,
    *,
    random_starts: int = RANDOM_STARTS,
    seed: int = SEED,
    evaluations: float = math.inf,
) -> tuple[WhirlState, ...]:
    """Steady whirl states on the mesh of the equations, by falling whirl speed.

    States of a string that stretches and twists are found from states of its lateral form, which Newton's method
    reaches from far more first guesses, and in a tenth of the time.

    Args:
        equations: Of a scene with a wall in a straight vertical hole.
        command: Weight on bit and rotation.
        random_starts: Random first shapes, besides the lowest modes.
        seed: Of the random shapes.
        evaluations: Of the equations, after which no other first guess is taken.

    Raises:
        SceneError: No steady whirl can exist in the scene.
    """
    check_whirls(equations, command)
    if equations.form != LATERAL:
        lateral = EquationsOfMotion(lateral_form(equations.scene, equations.model.rod.length.size))
        states, clearance = list[WhirlState](), TurningEquations(equations).clearance
        for one in _search(lateral, command, random_starts, seed, evaluations):
            whirl = across(equations, one.whirl)
            near = state_near(equations, whirl)
            if near is not None and is_new(near.whirl, [state.whirl for state in states], clearance):
                states.append(near)
        return tuple(sorted(states, key=lambda state: -state.whirl.omega))
    return _search(equations, command, random_starts, seed, evaluations)


@contextmanager
def _softened(turning: TurningEquations) -> Iterator[float]:
    """The equations with soft friction inside the block; gives the real regularisation [m/s]."""
    friction = getattr(turning.equations.parameters, "wall_friction", None)
    real = friction.creep if friction is not None else SOFT_CREEP
    set_creep(turning, max(SOFT_CREEP, real))
    try:
        yield real
    finally:
        set_creep(turning, real)


def _search(
    equations: EquationsOfMotion, command: Command, random_starts: int, seed: int, evaluations: float
) -> tuple[WhirlState, ...]:
    turning = TurningEquations(equations)
    found: list[SteadyWhirl] = []
    soft: list[SteadyWhirl] = []
    ends = equations.evaluations + evaluations
    with _softened(turning) as real:
        for guess in _guesses(ShapeSearch(turning, command), seed, random_starts):
            if equations.evaluations > ends:
                break
            _add_near(turning, guess, soft)
        for whirl in soft:
            set_creep(turning, max(SOFT_CREEP, real))
            stiff = stiffen_friction(turning, whirl, real)
            if stiff is not None and is_new(stiff, found, turning.clearance):
                found.append(stiff)
    ordered = sorted(found, key=lambda one: -one.omega)
    return tuple(state_of(turning, whirl) for whirl in ordered)


def lateral_form(scene: Scene, elements: int) -> Scene:
    """The scene without stretch, twist and the effects that need them, on a mesh of so many elements."""
    left_out = {key for key in SPATIAL_EFFECTS if key in scene.effect_names}
    left_out |= {key for key in scene.effect_names if left_out.intersection(getattr(scene.effects, key).requires)}
    return meshed(without(scene, sorted(left_out)), elements)


def across(equations: EquationsOfMotion, whirl: SteadyWhirl) -> SteadyWhirl:
    """A whirl of the lateral form as a first guess in another one, on the same mesh."""
    u, _ = equations.on_axis(whirl.command)
    u[:, ACROSS] = whirl.u[:, ACROSS]
    return replace(whirl, u=u)


def state_near(equations: EquationsOfMotion, whirl: SteadyWhirl) -> WhirlState | None:
    """Steady whirl near a shape and speed from elsewhere, such as a run in time; None if there is none."""
    turning = TurningEquations(equations)
    with _softened(turning) as real:
        shape = ShapeSearch(turning, whirl.command).relax(whirl.u, whirl.omega)
        soft = turning.newton(shape.whirl) if shape is not None else turning.newton(whirl)
        stiff = stiffen_friction(turning, soft, real) if soft is not None else None
    return state_of(turning, stiff) if stiff is not None and is_new(stiff, [], turning.clearance) else None


def rolling_ratios(model: DiscreteModel) -> tuple[float, ...]:
    """Whirl speed over the rotation of each part of the string that would roll on the wall, minus contact radius over
    clearance; parts within 1 % are one. A string with several cannot roll as a whole.
    """
    found: list[float] = []
    for ratio in np.unique(-model.contact_radius / model.wellbore.clearance):
        if not found or abs(ratio / found[-1] - 1.0) > SAME_ROLLING:
            found.append(float(ratio))
    return tuple(found)


def _guesses(search: ShapeSearch, seed: int, random_starts: int) -> Iterator[SteadyWhirl]:
    """First guesses: of fast whirls from shapes over whirl speeds, then of slow whirls from helices."""
    for start in search.starts(seed, random_starts):
        yield from search.crossings(search.family(start))
    yield from slow_whirls(search)


def _add_near(turning: TurningEquations, guess: SteadyWhirl, found: list[SteadyWhirl]) -> None:
    """Add the steady whirls that Newton's method finds from a guess, each deflated before the next is sought."""
    whirl = turning.newton(guess)
    for _ in range(DEFLATIONS):
        if whirl is None or not is_new(whirl, found, turning.clearance):
            break
        found.append(whirl)
        whirl = turning.newton(guess, partial(deflation, turning, found))


def is_new(whirl: SteadyWhirl, others: Sequence[SteadyWhirl], clearance: float) -> bool:
    """True for a whirl on the wall that is none of others of the same mesh."""
    if float(whirl.radius.max()) < 0.9 * clearance:
        return False
    rotation = abs(whirl.command.rotation)
    return not any(
        abs(whirl.omega - other.omega) < SAME_SPEED * rotation
        and float(np.abs(whirl.radius - other.radius).max()) < SAME_SHAPE * clearance
        for other in others
    )


def start_in_whirl(scene: Scene) -> tuple[Array, Array, Command]:
    """Position and velocity of the steady whirl whose disturbances decay fastest, or grow slowest, and its command.

    Raises:
        SceneError: No steady whirl can exist in the scene.
        RunError: None was found.
    """
    weight, rotation = scene.rig.first
    states = whirl_states(EquationsOfMotion(scene), Command(weight, rotation))
    if not states:
        raise RunError(
            f"{scene.name}: rig.start: expected a steady whirl at {weight:g} N and {rotation / math.tau:g} rev/s, "
            "found none; start from the axis instead (rig.start: axis)"
        )
    whirl = min(states, key=lambda state: state.growth).whirl
    u, v, _ = whirl.motion
    return u, v, whirl.command
