# SPDX-License-Identifier: Apache-2.0
"""Classification of the motion of each mark and of the string by `Criteria` into `MotionState`."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array, Integers, Mask
from drill_twin.core.compile.jit import strict_kernel
from drill_twin.whirl.criteria import Criteria
from drill_twin.whirl.motion.states import (
    AT_REST,
    CHANGED,
    FIXED_AXIS,
    FORWARD,
    HIDDEN,
    IRREGULAR,
    REVERSE,
    ROLLING,
    SECOND_BENDING,
    SPIRAL,
    SWING,
    SYNCHRONOUS,
    StateHysteresis,
    is_whirl,
    update_states,
)
from drill_twin.whirl.onset.asynchronous_onset import Onsets
from drill_twin.whirl.onset.synchronous_onset import SynchronousOnsets
from drill_twin.whirl.orbit.orbit import LAG, PLANARITY, RECENT_ROTATION, SECOND_LOBE, Orbit, StringShape, is_aliased
from drill_twin.whirl.sample_bins import REVOLUTIONS, TIME

RISE = 0.1
"""Irregular motion starts when its share of the time last rose above this."""


class Irregularity(NamedTuple):
    """Share of irregular time of m marks, fading over `Criteria.irregularity_memory` revolutions, with hysteresis."""

    active: Mask  # (m,) in irregular motion now
    rose: Array  # (m,) time at which the share last rose, since the first sample [s]
    last: Array  # (m,) time at which the motion was last irregular, since the first sample [s]
    share: Array  # (m,)
    revolutions: Array  # (1,) of the last estimate [rev]

    @classmethod
    def of(cls, m: int) -> Irregularity:
        """Before the first estimate."""
        return cls(np.zeros(m, bool), np.zeros(m), np.zeros(m), np.zeros(m), np.zeros(1))


@strict_kernel
def update_irregularity(
    irregularity: Irregularity,
    orbit: Orbit,
    asynchronous: Mask,
    detected: Array,
    criteria: Criteria,
    time: float,
    revolutions: float,
) -> None:
    """Add an estimate.

    Args:
        irregularity: The shares.
        orbit: Orbits of the marks.
        asynchronous: Marks in asynchronous whirl, shape (m,).
        detected: Detection of that whirl [rev], shape (m,).
        criteria: Thresholds.
        time: Time since the first sample [s].
        revolutions: Revolutions since the first sample [rev].
    """
    gain = 1.0 - math.exp(-(revolutions - irregularity.revolutions[0]) / criteria.irregularity_memory)
    irregularity.revolutions[0] = revolutions
    for k in range(detected.size):
        row = 0 if asynchronous[k] else 1
        settled = revolutions - detected[k] > criteria.settling_time
        rough = orbit.coherence[row, k] < criteria.coherence or orbit.unevenness[row, k] > criteria.unevenness
        before, share = irregularity.share[k], 0.0
        if settled:
            share = before + gain * ((1.0 if rough else 0.0) - before)
        if before < RISE <= share:
            irregularity.rose[k] = time
        if settled and rough:
            irregularity.last[k] = time
        held = irregularity.active[k] and share > criteria.irregularity_off
        irregularity.active[k] = share > criteria.irregularity_on or held
        irregularity.share[k] = share


LONGEST_DELAY = 8.0
"""Largest shift of the start of irregular motion into the past, over half the window."""


HELICAL, TWO_SIDED = 0, 1
"""Indices into `MotionClassifier.shape`."""


class MotionClassifier(NamedTuple):
    """Motion state of m marks and, last, of the string."""

    hysteresis: StateHysteresis
    irregularity: Irregularity
    in_contact: Mask  # (m,)
    still: Mask  # (m,)
    rolls: Mask  # (m,) the contact point slips little, if there is contact
    shape: Mask  # (2,) the string is a helix; it has marks on both sides
    dated: Array  # (m + 1,) begin of the whirl of each subject that has a period [s], nan without
    mark: Integers  # (m + 1,) whose orbit tells the state of a subject
    began: Array  # (m + 1,) begin of the whirl of each subject [s], nan without

    @classmethod
    def of(cls, m: int) -> MotionClassifier:
        """Before the first estimate."""
        in_contact, still, rolls = np.zeros((3, m), bool)
        return cls(
            StateHysteresis.of(m + 1), Irregularity.of(m), in_contact, still, rolls, np.zeros(2, bool),
            np.full(m + 1, math.nan), np.append(np.arange(m), 0), np.full(m + 1, math.nan),
        )  # fmt: skip


@strict_kernel
def classify(
    motion: MotionClassifier,
    orbit: Orbit,
    shape: StringShape,
    onsets: Onsets,
    synchronous: SynchronousOnsets,
    criteria: Criteria,
    rolling_ratio: Array,
    numbers: Array,
) -> bool:
    """Estimate the states and apply the hysteresis.

    Args:
        motion: The states.
        orbit: Orbits of the marks.
        shape: Shape of the string.
        onsets: Asynchronous whirl of the marks.
        synchronous: Synchronous whirl of the marks.
        criteria: Thresholds.
        rolling_ratio: Whirl ratio in pure rolling, shape (m,).
        numbers: Those of the newest bin.

    Returns:
        Whether a state changes or has settled.
    """
    hysteresis, whirling = motion.hysteresis, onsets.active
    time, revolutions, m = numbers[TIME], numbers[REVOLUTIONS], whirling.size
    _update_flags(motion, orbit, criteria, whirling, rolling_ratio)
    update_irregularity(motion.irregularity, orbit, whirling, onsets.detected, criteria, time, revolutions)
    _update_shape(motion.shape, shape, criteria)
    motion.began[m] = math.nan
    for k in range(m):
        motion.began[k] = synchronous.began[k] if math.isnan(onsets.began[k]) else onsets.began[k]
        motion.began[m] = np.fmin(motion.began[m], motion.began[k])
        hysteresis.estimate[k] = _of_mark(motion, orbit, onsets, criteria, k, synchronous.active[k])
    reference = _reference_mark(orbit, shape, whirling, synchronous.active)
    motion.mark[m] = reference
    hysteresis.estimate[m] = _of_string(motion.shape, hysteresis.estimate[reference])
    for subject in range(m + 1):
        hysteresis.start[subject] = _start(motion, subject, orbit.numbers[LAG], time)
    any_event = update_states(hysteresis, criteria, orbit.numbers[LAG], time, revolutions)
    for subject in range(m + 1):
        if hysteresis.event[subject] == CHANGED and is_whirl(hysteresis.held[subject]):
            motion.dated[subject] = motion.began[subject]
    return any_event


@strict_kernel
def _reference_mark(orbit: Orbit, shape: StringShape, whirling: Mask, synchronous: Mask) -> int:
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
def _start(motion: MotionClassifier, subject: int, lag: float, time: float) -> float:
    """Start of the estimated state [s], where it is known better than from the hysteresis; else nan."""
    held, estimate = motion.hysteresis.held[subject], motion.hysteresis.estimate[subject]
    mark, began = motion.mark[subject], motion.began[subject]
    if not is_whirl(held):
        # A whirl goes on after the string stood for a while; its begin is that of its first period.
        return began if is_whirl(estimate) and began != motion.dated[subject] else math.nan
    if estimate == IRREGULAR:
        return float(max(motion.irregularity.rose[mark], time - LONGEST_DELAY * lag) - lag)
    if held == IRREGULAR and is_whirl(estimate):
        # The last irregular window ends up to a window, two lags, after the change.
        return float(max(motion.irregularity.last[mark], time - LONGEST_DELAY * lag) - 1.5 * lag)
    return math.nan


@strict_kernel
def _update_flags(
    motion: MotionClassifier, orbit: Orbit, criteria: Criteria, whirling: Mask, rolling_ratio: Array
) -> None:
    """Update the criteria of the marks that have a hysteresis of their own."""
    share = criteria.standing_share
    for k in range(whirling.size):
        row = 0 if whirling[k] else 1
        steady = 1.0 - orbit.coherence[row, k] < share * (1.0 - criteria.coherence)
        motion.still[k] = steady and orbit.unevenness[row, k] < share * criteria.unevenness
        contact, least = orbit.contact[k], criteria.contact_fraction
        leaves = contact < least - criteria.contact_hysteresis
        motion.in_contact[k] = contact > least or (motion.in_contact[k] and not leaves)
        slip = _slip(orbit.ratio[k], rolling_ratio[k])
        slides = slip > criteria.rolling_slip + 0.1
        motion.rolls[k] = slip < criteria.rolling_slip or (motion.rolls[k] and not slides)


@strict_kernel
def _update_shape(flags: Mask, shape: StringShape, criteria: Criteria) -> None:
    """Update the criteria of the string that have a hysteresis of their own."""
    several = shape.levels.size > 1
    planar = criteria.planar + (0.1 if flags[HELICAL] else 0.0)
    lobe = criteria.lobe - (0.1 if flags[TWO_SIDED] else 0.0)
    flags[HELICAL] = several and shape.numbers[PLANARITY] < planar
    flags[TWO_SIDED] = several and shape.numbers[SECOND_LOBE] > lobe


@strict_kernel
def _slip(ratio: float, rolling_ratio: float) -> float:
    """Slip of the contact point over the rim speed; 0 for any backward whirl where the rim is not known."""
    if not ratio < 0.0:
        return math.inf
    return abs(1.0 - ratio / rolling_ratio) if rolling_ratio < 0.0 else 0.0


@strict_kernel
def _of_mark(
    motion: MotionClassifier, orbit: Orbit, onsets: Onsets, criteria: Criteria, k: int, synchronous: bool
) -> int:
    """Estimated state of a mark, in asynchronous or synchronous whirl."""
    ratio = orbit.ratio[k]
    if abs(orbit.numbers[RECENT_ROTATION]) < criteria.rest_rotation:
        return AT_REST
    if is_aliased(orbit, criteria) or not orbit.seen[k]:
        return HIDDEN
    if not onsets.active[k]:
        held = motion.hysteresis.held[k] == SWING
        swings = onsets.swing[k] > (criteria.release_radius if held else criteria.onset_radius)
        return SYNCHRONOUS if synchronous else SWING if swings else FIXED_AXIS
    if motion.irregularity.active[k]:
        return IRREGULAR
    if abs(ratio) < criteria.standing_ratio and motion.still[k]:
        return FIXED_AXIS
    if motion.in_contact[k] and motion.rolls[k]:
        return ROLLING
    return FORWARD if ratio > 0.0 else REVERSE


@strict_kernel
def _of_string(shape: Mask, reference: int) -> int:
    """Estimated state of the string, from that of its reference mark."""
    if not is_whirl(reference) or reference == IRREGULAR:
        return reference
    if shape[HELICAL]:
        return SPIRAL
    return SECOND_BENDING if shape[TWO_SIDED] else reference
