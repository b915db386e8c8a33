# SPDX-License-Identifier: Apache-2.0
"""The truth that the analyzer is measured against: prescribed motions get the labels they were made with."""

import math

import numpy as np
import pytest

from drill_twin.whirl import MarkInfo, MotionState
from drill_twin_evidence.detection.ground_truth import asynchronous, onset, truth_of
from drill_twin_evidence.detection.runs import Run
from drill_twin_evidence.detection.scoring import STATES, f1_scores, macro_f1
from drill_twin_evidence.detection.signals import MOTIONS, labelled, steady

CLEARANCE, OUTER = 0.08, 0.008
TIME = np.arange(0.0, 25.0, 0.01)
SPEED = 2.0
ANGLE = math.tau * SPEED * TIME
GROWN = np.clip((TIME - 10.0) / 1.0, 0.0, 1.0)


def run_of(part):
    """A run whose nodes move by `part` [of the clearance], shape (T, nodes), with marks at every second node."""
    nodes = part.shape[1]
    arc = np.linspace(0.0, 5.0, nodes)
    centre = CLEARANCE * part
    spin = np.broadcast_to(ANGLE[:, None], part.shape)
    marks = tuple(MarkInfo(f"m{k}", float(arc[k]), "wall", OUTER, CLEARANCE) for k in range(0, nodes, 2))
    at = slice(None, None, 2)
    zero = np.zeros_like(spin)
    return Run(
        "made up", marks, TIME, np.full(TIME.size, math.tau * SPEED), centre[:, at], spin[:, at], zero[:, at],
        centre[:, at], arc, centre, spin, np.full(nodes, CLEARANCE), vertical=True,
    )  # fmt: skip


def whirl(ratio, shape, level):
    return (GROWN * level * np.exp(1j * ratio * ANGLE))[:, None] * np.asarray(shape)[None, :]


ALONG = np.linspace(0.0, 1.0, 9)
ONE_SIDE = np.sin(np.pi * ALONG)


@pytest.mark.parametrize(
    ("ratio", "shape", "level", "state"),
    [
        (0.5, ONE_SIDE, 0.6, "forward whirl"),
        (-0.5, ONE_SIDE, 0.6, "backward whirl"),
        (-0.1, ONE_SIDE, 1.0, "rolling along the wall"),
        (-0.02, ONE_SIDE, 1.0, "creeping along the wall"),
        (0.5, ONE_SIDE, 1.0, "forward whirl"),
        (0.5, np.sin(2.0 * np.pi * ALONG), 0.6, "second bending"),
        (0.5, np.exp(2j * np.pi * ALONG), 0.6, "spiral"),
    ],
)
def test_states_of_known_motions(ratio, shape, level, state):
    truth = truth_of(run_of(whirl(ratio, shape, level)))
    late = [found for time, found in zip(truth.time, truth.motion, strict=True) if 15.0 < time < 24.0]
    assert set(late) == {state}
    assert truth.onset == pytest.approx(10.0 + 0.05 / level, abs=0.05)
    early = [found for time, found in zip(truth.time, truth.motion, strict=True) if 1.0 < time < 10.0]
    assert set(early) == {"rotation about a fixed axis"}


def test_motion_without_pace_is_irregular():
    draw = np.random.default_rng(3)
    path = sum(
        np.exp(1j * (p * ANGLE + a)) for p, a in zip(draw.normal(0, 0.7, 20), draw.uniform(0, 6, 20), strict=True)
    )
    truth = truth_of(run_of((GROWN * 0.1 * path)[:, None] * ONE_SIDE[None, :]))
    late = [found for time, found in zip(truth.time, truth.motion, strict=True) if time > 14.0]
    assert late.count("irregular") > 0.8 * len(late)


def test_whirl_that_strikes_the_wall():
    hops = (0.85 + 0.15 * np.cos(3.0 * ANGLE))[:, None]
    truth = truth_of(run_of(hops * whirl(-0.5, ONE_SIDE, 1.0)))
    late = [found for time, found in zip(truth.time, truth.motion, strict=True) if 15.0 < time < 24.0]
    assert set(late) == {"striking the wall"}


def test_bow_and_lean_are_no_whirl():
    turn = np.exp(1j * ANGLE)
    bow = run_of((0.3 * turn)[:, None] * ONE_SIDE[None, :])
    assert truth_of(bow).onset is None
    lean = 0.5 * (1.0 - np.exp(-np.maximum(TIME - 8.0, 0.0)))
    assert onset(TIME, lean.astype(complex), ANGLE) is None
    assert onset(TIME, 0.5 * np.exp(0.1j * ANGLE), ANGLE) == 0.0


def test_short_excursion_is_no_onset():
    """Less than a revolution above 5 %."""
    burst = 0.5 * np.exp(1j * 0.3 * ANGLE) * ((TIME > 5.0) & (TIME < 5.4))
    assert onset(TIME, burst, ANGLE) is None


def test_synchronous_part_is_taken_off():
    turn = np.exp(1j * ANGLE)[:, None]
    rest = asynchronous(0.2 * turn + 0.1 * np.exp(-0.4j * ANGLE)[:, None], ANGLE[:, None], ANGLE / math.tau)
    assert np.abs(rest[2000:]) == pytest.approx(0.1, abs=0.003)


def test_labels_are_the_analyzers_words():
    assert set(STATES) == {state.value for state in MotionState}
    assert set(MOTIONS) < set(STATES)


def test_records_are_drawn_from_their_seed():
    one, again = labelled(5), labelled(5)
    assert np.array_equal(one.position, again.position, equal_nan=True)
    assert one.truth.motion == again.truth.motion
    assert labelled(6).name != one.name
    assert {labelled(seed).truth.motion[-1] for seed in range(36)} == set(MOTIONS)
    assert steady(1).truth.onset is None


def test_f1():
    confusion = np.zeros((len(STATES), len(STATES)), np.int64)
    confusion[1, 1], confusion[1, 2], confusion[2, 2] = 6, 2, 4
    assert f1_scores(confusion) == pytest.approx({STATES[1]: 12 / 14, STATES[2]: 8 / 10})
    assert macro_f1(confusion) == pytest.approx((12 / 14 + 0.8) / 2)
