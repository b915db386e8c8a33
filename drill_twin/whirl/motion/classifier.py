# SPDX-License-Identifier: Apache-2.0
"""Classification of the motion of each mark and of the string by `criteria` into `MotionState`."""

import math

import numpy as np

from drill_twin.core.arrays import Array, Mask
from drill_twin.core.compile.jit import strict_kernel
from drill_twin.whirl import criteria
from drill_twin.whirl.columns import Columns, columns
from drill_twin.whirl.history import CAPACITY, bins_in, end_of
from drill_twin.whirl.motion.states import (
    AT_REST,
    CHANGED,
    CREEPING,
    FIXED_AXIS,
    FORWARD,
    HIDDEN,
    IMPACTS,
    IRREGULAR,
    REVERSE,
    ROLLING,
    SECOND_BENDING,
    SPIRAL,
    SWING,
    SYNCHRONOUS,
    is_whirl,
    new_hysteresis,
    update_states,
)
from drill_twin.whirl.orbit.orbit import is_aliased
from drill_twin.whirl.orbit.two_lines import find_lines

RISE = 0.1
"""Irregular motion starts when its share of the time last rose above this."""


def new_irregularity(m: int) -> Columns:
    """Share of irregular time of m marks, before the first estimate.

    It fades over `criteria.IRREGULARITY_MEMORY` revolutions, and has a hysteresis.
    """
    return columns(
        "Irregularity",
        m,
        active=False,  # in irregular motion now
        rose=0.0,  # time at which the share last rose, since the first sample [s]
        last=0.0,  # time at which the motion was last irregular, since the first sample [s]
        share=0.0,
        revolutions=np.zeros(1),  # of the last estimate [rev]
    )


@strict_kernel
def update_irregularity(
    irregularity: Columns,
    orbit: Columns,
    asynchronous: Mask,
    detected: Array,
    time: float,
    revolutions: float,
) -> None:
    """Add an estimate.

    Args:
        irregularity: The shares.
        orbit: Orbits of the marks.
        asynchronous: Marks in asynchronous whirl, shape (m,).
        detected: Detection of that whirl [rev], shape (m,).
        time: Time since the first sample [s].
        revolutions: Revolutions since the first sample [rev].
    """
    gain = 1.0 - math.exp(-(revolutions - irregularity.revolutions[0]) / criteria.IRREGULARITY_MEMORY)
    irregularity.revolutions[0] = revolutions
    for k in range(detected.size):
        row = 0 if asynchronous[k] else 1
        settled = revolutions - detected[k] > criteria.SETTLING_TIME
        rough = orbit.coherence[row, k] < criteria.COHERENCE or orbit.unevenness[row, k] > criteria.UNEVENNESS
        before, share = irregularity.share[k], 0.0
        if settled:
            share = before + gain * ((1.0 if rough else 0.0) - before)
        if before < RISE <= share:
            irregularity.rose[k] = time
        if settled and rough:
            irregularity.last[k] = time
        held = irregularity.active[k] and share > criteria.IRREGULARITY_OFF
        irregularity.active[k] = share > criteria.IRREGULARITY_ON or held
        irregularity.share[k] = share


LONGEST_DELAY = 8.0
"""Largest shift of the start of irregular motion into the past, over half the window."""


def new_motion(m: int) -> Columns:
    """Motion states of m marks and, last, of the string, before the first estimate."""
    return columns(
        "MotionClassifier",
        m,
        hysteresis=new_hysteresis(m + 1),
        irregularity=new_irregularity(m),
        in_contact=False,
        still=False,
        strikes=False,  # the wall, again and again
        lines=np.zeros((m, 2, 2)),  # rate [rad/s] and radius [m] of the two strongest lines of the asynchronous part
        due=np.zeros(1),  # revolutions at which the lines are found again [rev]
        rest=np.zeros((2, CAPACITY), complex),  # work
        creeps=False,  # the contact point moves backward more slowly than in rolling
        rolls=False,  # the contact point slips little, if there is contact
        helical=np.zeros(1, bool),  # the string is a helix
        two_sided=np.zeros(1, bool),  # the string has marks on both sides of the axis
        dated=np.full(m + 1, math.nan),  # begin of the whirl of each subject that has a period [s], nan without
        mark=np.append(np.arange(m), 0),  # mark whose orbit tells the state of a subject
        began=np.full(m + 1, math.nan),  # begin of the whirl of each subject [s], nan without
    )


@strict_kernel
def find_two_lines(motion: Columns, orbit: Columns, history: Columns, onsets: Columns, carried: Array) -> None:
    """Find the lines of the marks in asynchronous whirl once a revolution; two regular lines give the precession.

    `carried` are the rates of fast orbits, or 0 [rad/s], shape (m,).
    """
    revolutions = history.revolutions[end_of(history) - 1]
    due = revolutions >= motion.due[0]
    if due:
        motion.due[0] = revolutions + 1.0
    for k in range(onsets.active.size):
        if not onsets.active[k]:
            orbit.left[k] = 0.0
        elif due:
            n = bins_in(history, min(criteria.LINES_WINDOW, revolutions - onsets.detected[k] + criteria.SUSTAIN))
            orbit.left[k] = find_lines(history, k, carried[k], motion.rest[0, :n], motion.rest[1, :n], motion.lines[k])
        if motion.irregularity.active[k] and orbit.left[k] < criteria.LEFT and math.isfinite(orbit.ratio[k]):
            rotation = orbit.rotation[0]
            orbit.precession[k] = math.copysign(1.0, rotation) * motion.lines[k, 0, 0] / math.tau
            orbit.ratio[k] = orbit.precession[k] / abs(rotation)


@strict_kernel
def classify(
    motion: Columns,
    orbit: Columns,
    shape: Columns,
    onsets: Columns,
    synchronous: Columns,
    rolling_ratio: Array,
    full: Columns,
) -> bool:
    """Estimate the states and apply the hysteresis.

    Args:
        motion: The states.
        orbit: Orbits of the marks.
        shape: Shape of the string.
        onsets: Asynchronous whirl of the marks.
        synchronous: Synchronous whirl of the marks.
        rolling_ratio: Whirl ratio in pure rolling, shape (m,).
        full: The newest bin.

    Returns:
        Whether a state changes or has settled.
    """
    hysteresis, whirling = motion.hysteresis, onsets.active
    time, revolutions, m = full.time[0], full.revolutions[0], whirling.size
    _update_flags(motion, orbit, whirling, rolling_ratio)
    update_irregularity(motion.irregularity, orbit, whirling, onsets.detected, time, revolutions)
    _update_shape(motion, shape)
    motion.began[m] = math.nan
    for k in range(m):
        motion.began[k] = synchronous.began[k] if math.isnan(onsets.began[k]) else onsets.began[k]
        motion.began[m] = np.fmin(motion.began[m], motion.began[k])
        hysteresis.estimate[k] = _of_mark(motion, orbit, onsets, k, synchronous.active[k])
    reference = _reference_mark(orbit, shape, whirling, synchronous.active)
    motion.mark[m] = reference
    hysteresis.estimate[m] = _of_string(motion, hysteresis.estimate[reference])
    for subject in range(m + 1):
        hysteresis.start[subject] = _start(motion, subject, orbit.lag[0], time)
        mark = motion.mark[subject]
        if hysteresis.estimate[subject] == HIDDEN and not orbit.seen[mark] and orbit.last_seen[mark] < time:
            hysteresis.start[subject] = orbit.last_seen[mark]
    any_event = update_states(hysteresis, orbit.lag[0], time, revolutions)
    for subject in range(m + 1):
        if hysteresis.event[subject] == CHANGED and is_whirl(hysteresis.held[subject]):
            motion.dated[subject] = motion.began[subject]
    return any_event


@strict_kernel
def _reference_mark(orbit: Columns, shape: Columns, whirling: Mask, synchronous: Mask) -> int:
    """Mark whose state the string takes: the whirling mark with the largest motion, if any whirls."""
    reference, largest = -1, 0.0
    for k in range(whirling.size):
        if (whirling[k] or synchronous[k]) and orbit.seen[k] and (reference < 0 or shape.power[k] > largest):
            reference, largest = k, shape.power[k]
    if reference < 0:
        reference = shape.reference[0]
    if not orbit.seen[reference]:
        reference, largest = 0, -1.0
        for k in range(whirling.size):
            if orbit.seen[k] and shape.power[k] > largest:
                reference, largest = k, shape.power[k]
    return reference


@strict_kernel
def _start(motion: Columns, subject: int, lag: float, time: float) -> float:
    """Start of the estimated state [s], where it is known better than from the hysteresis; else nan."""
    held, estimate = motion.hysteresis.held[subject], motion.hysteresis.estimate[subject]
    mark, began = motion.mark[subject], motion.began[subject]
    if not is_whirl(held):
        # A whirl goes on after the string stood for a while; it began with its first period.
        return began if is_whirl(estimate) and began != motion.dated[subject] else math.nan
    if estimate == IRREGULAR:
        return float(max(motion.irregularity.rose[mark], time - LONGEST_DELAY * lag) - lag)
    if held == IRREGULAR and is_whirl(estimate):
        # The last irregular window ends up to a window, two lags, after the change.
        return float(max(motion.irregularity.last[mark], time - LONGEST_DELAY * lag) - 1.5 * lag)
    return math.nan


@strict_kernel
def _update_flags(motion: Columns, orbit: Columns, whirling: Mask, rolling_ratio: Array) -> None:
    """Update the criteria of the marks that have a hysteresis of their own."""
    share = criteria.STANDING_SHARE
    for k in range(whirling.size):
        row = 0 if whirling[k] else 1
        steady = 1.0 - orbit.coherence[row, k] < share * (1.0 - criteria.COHERENCE)
        motion.still[k] = steady and orbit.unevenness[row, k] < share * criteria.UNEVENNESS
        contact, least = orbit.contact[k], criteria.CONTACT_FRACTION
        leaves = contact < least - criteria.CONTACT_HYSTERESIS
        motion.in_contact[k] = contact > least or (motion.in_contact[k] and not leaves)
        most = criteria.STRIKES * (0.5 if motion.strikes[k] else 1.0)
        motion.strikes[k] = orbit.strikes[k] >= most and not motion.in_contact[k]
        slip = _slip(orbit.ratio[k], rolling_ratio[k])
        slides = slip > criteria.ROLLING_SLIP + 0.1
        motion.creeps[k] = rolling_ratio[k] < orbit.ratio[k] < 0.0
        motion.rolls[k] = slip < criteria.ROLLING_SLIP or (motion.rolls[k] and not slides)


@strict_kernel
def _update_shape(motion: Columns, shape: Columns) -> None:
    """Update the criteria of the string that have a hysteresis of their own."""
    several = shape.levels.size > 1
    planar = criteria.PLANAR + (0.1 if motion.helical[0] else 0.0)
    lobe = criteria.LOBE - (0.1 if motion.two_sided[0] else 0.0)
    motion.helical[0] = several and shape.planarity[0] < planar
    motion.two_sided[0] = several and shape.second_lobe[0] > lobe


@strict_kernel
def _slip(ratio: float, rolling_ratio: float) -> float:
    """Slip of the contact point over the rim speed; 0 for any backward whirl where the rim is not known."""
    if not ratio < 0.0:
        return math.inf
    return abs(1.0 - ratio / rolling_ratio) if rolling_ratio < 0.0 else 0.0


@strict_kernel
def _of_mark(motion: Columns, orbit: Columns, onsets: Columns, k: int, synchronous: bool) -> int:
    """Estimated state of a mark, in asynchronous or synchronous whirl."""
    ratio = orbit.ratio[k]
    if abs(orbit.recent_rotation[0]) < criteria.REST_ROTATION:
        return AT_REST
    if is_aliased(orbit) or not orbit.seen[k]:
        return HIDDEN
    if not onsets.active[k]:
        held = motion.hysteresis.held[k] == SWING
        swings = onsets.swing[k] > (criteria.RELEASE_RADIUS if held else criteria.ONSET_RADIUS)
        return SYNCHRONOUS if synchronous else SWING if swings else FIXED_AXIS
    if motion.irregularity.active[k] and orbit.left[k] >= criteria.LEFT:
        return IRREGULAR
    if abs(ratio) < criteria.STANDING_RATIO and motion.still[k]:
        return FIXED_AXIS
    if motion.strikes[k]:
        return IMPACTS
    if motion.in_contact[k] and (motion.rolls[k] or motion.creeps[k]):
        return ROLLING if motion.rolls[k] else CREEPING
    return FORWARD if ratio > 0.0 else REVERSE


@strict_kernel
def _of_string(motion: Columns, reference: int) -> int:
    """Estimated state of the string, from the state of its reference mark."""
    if not is_whirl(reference) or reference == IRREGULAR:
        return reference
    if motion.helical[0]:
        return SPIRAL
    return SECOND_BENDING if motion.two_sided[0] else reference
