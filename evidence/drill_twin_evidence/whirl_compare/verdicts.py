# SPDX-License-Identifier: Apache-2.0
"""Verdict on a simulated motion: whether it is a state that was computed."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from drill_twin.core.arrays import Array, number_or_none
from drill_twin.dynamics.rotordynamics.equations import EquationsOfMotion
from drill_twin.dynamics.rotordynamics.steady.imperfections import modulation
from drill_twin.dynamics.rotordynamics.steady.steady_whirl import TurningEquations
from drill_twin.dynamics.rotordynamics.steady.whirl_state import WhirlState
from drill_twin.scene.set_points.command import Command
from drill_twin_evidence.whirl_compare.harmonic_balance import TwoFrequencyWhirl
from drill_twin_evidence.whirl_compare.motion import AXIS, STEADY, TWO, Motion, motion_of
from drill_twin_evidence.whirl_compare.points import COEXISTS, MISSED, MODULATED, NO_STATE, ON_STATE, PAST_HOPF, Point

MOST_MARKS = 99
SAME_SPEED, SAME_RATIO = 0.02, 1e-3
"""Whirl speeds agree within this share, or within this share of the rotation."""
SAME_RADIUS = 0.05
"""Largest difference of mean radii over the clearance between a run and a computed whirl with two frequencies."""
MODULATION, SAME_BEAT = 0.3, 0.1
"""Largest change of the shape, over the clearance, of a whirl with a modulation, and difference of the frequency of a
modulation from that of the rotation or of the state's oscillation in the frame of the whirl, as a share."""
BEATS = 10
"""Periods of a modulation over which it is measured."""


def judge(
    equations: EquationsOfMotion, states: Sequence[WhirlState], axis: float, command: Command, motion: Motion
) -> Point:
    """Verdict on a motion, given the states and the growth on the axis [1/s]."""
    rotation = command.rotation
    stable = tuple(state.ratio for state in states if state.is_stable)
    own = next((one for one in states if one.is_stable and near(motion.speed / rotation, (one.ratio,))), None)
    change = _predicted(equations, own) if own is not None else None
    if motion.kind == AXIS:
        verdict = ON_STATE if axis < 0.0 else MISSED
    elif motion.kind == STEADY and own is not None:
        verdict = ON_STATE
    elif motion.kind == TWO and own is not None and _beats(motion, rotation - motion.speed):
        verdict = MODULATED
    elif motion.kind in {STEADY, TWO} and any(_about(equations, one, motion) for one in states if not one.is_stable):
        verdict = PAST_HOPF
    elif motion.kind in {STEADY, TWO}:
        verdict = MISSED
    else:
        verdict = COEXISTS if stable or axis < 0.0 else NO_STATE
    second, simulated = map(number_or_none, (motion.second / rotation, motion.change))
    found = ((0.0, axis, 0.0), *((one.ratio, one.growth, one.growth_frequency) for one in states))
    ratio = motion.speed / rotation
    return Point(command.weight_on_bit, rotation, motion.kind, ratio, second, simulated, found, stable, verdict, change)


def is_on(equations: EquationsOfMotion, whirl: TwoFrequencyWhirl, motion: Motion) -> bool:
    """True if a motion has both speeds and the mean radii of a whirl with two frequencies."""
    rotation = whirl.command.rotation
    moved = whirl.even.value @ whirl.coefficients
    radii = np.zeros((len(moved), *equations.free.shape))
    radii[:, equations.free] = moved
    radius = np.hypot(radii[..., 0], radii[..., 1]).mean(axis=0) / equations.scene.least_clearance
    same = (
        near(a / rotation, (b / rotation,)) for a, b in ((motion.speed, whirl.omega), (motion.second, whirl.second))
    )
    apart = np.interp(places(equations), equations.model.rod.arc, radius) - motion.radius
    return all(same) and float(np.abs(apart).max()) < SAME_RADIUS


def places(equations: EquationsOfMotion) -> Array:
    """Distances of the marks from the bit [m]: the nodes below the top, or some of them."""
    arc = equations.model.rod.arc[:-1]
    return np.asarray(arc[:: math.ceil(arc.size / MOST_MARKS)])


def near(ratio: float, others: Sequence[float]) -> bool:
    """True if a whirl speed over the rotation is one of others."""
    return any(abs(ratio - other) < max(SAME_SPEED * abs(other), SAME_RATIO) for other in others)


def _predicted(equations: EquationsOfMotion, state: WhirlState) -> float:
    """Change of the shape of a state by bow and eccentricity, to first order, measured as that of a run."""
    found = modulation(TurningEquations(equations), state.whirl)
    beats = math.tau * BEATS / max(abs(found.rate), 1e-3)
    times = np.linspace(0.0, beats, 40 * BEATS)
    arc, marks = equations.model.rod.arc, places(equations)
    line = np.array([np.interp(marks, arc, one) for one in found.line(times)])
    return motion_of(line, float(times[1]), equations.scene.least_clearance).change


def _beats(motion: Motion, rate: float) -> bool:
    """True if a motion of two frequencies is a modulation at a rate [rad/s] in the frame of its whirl."""
    return abs(abs(motion.second - motion.speed) / max(abs(rate), 1e-9) - 1.0) < SAME_BEAT


def _about(equations: EquationsOfMotion, state: WhirlState, motion: Motion) -> bool:
    """True if a motion has speed and radii of an unstable state, and is modulated as that is left, or hardly at all."""
    radius = np.interp(places(equations), equations.model.rod.arc, state.whirl.radius) / equations.scene.least_clearance
    same = near(motion.speed / state.whirl.command.rotation, (state.ratio,))
    like = same and float(np.abs(radius - motion.radius).max()) < MODULATION and motion.change < MODULATION
    return like and (motion.kind == STEADY or _beats(motion, math.tau * state.growth_frequency))
