# SPDX-License-Identifier: Apache-2.0
"""The truth that the analyzer is measured against: prescribed motions get the labels they were made with."""

import math

import numpy as np
import pytest

from drill_twin.whirl import MarkInfo, MotionState
from drill_twin_evidence.detection.frozen.score import STATES
from drill_twin_evidence.detection.frozen.simulated import truth_of
from drill_twin_evidence.detection.ground_truth import asynchronous, mark_onsets, onset
from drill_twin_evidence.detection.runs import Run

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
        (0.5, ONE_SIDE, 1.0, "forward whirl"),
        (0.5, np.sin(2.0 * np.pi * ALONG), 0.6, "second bending"),
        (0.5, np.exp(2j * np.pi * ALONG), 0.6, "spiral"),
    ],
)
def test_states_of_known_motions(ratio, shape, level, state):
    run = run_of(whirl(ratio, shape, level))
    truth = truth_of(run, None)
    late = truth["states"][0][(truth["at"] > 15.0) & (truth["at"] < 22.0)]
    assert set(late.tolist()) == {state}
    assert set(truth["states"][0][truth["at"] < 9.0].tolist()) == {"rotation about a fixed axis"}
    assert min(time for time in mark_onsets(run) if time) == pytest.approx(10.0 + 0.05 / level, abs=0.05)


def test_amplitude_of_a_run_is_that_of_its_growth():
    """Growth by e in two revolutions from 0.001 to the wall: the time at any level is known without a threshold."""
    grown = np.minimum(0.001 * np.exp(1.0 * (TIME - 5.0)), 0.9)
    run = run_of(grown[:, None] * np.exp(0.5j * ANGLE)[:, None] * ONE_SIDE[None, :])
    truth = truth_of(run, True)
    for level in (0.03, 0.1):
        found = truth["at"][np.argmax(truth["amplitude"].max(axis=1) > level)]
        assert found == pytest.approx(5.0 + math.log(level / 0.001), abs=0.2)


def test_bow_is_no_whirl():
    bow = run_of((0.3 * np.exp(1j * ANGLE))[:, None] * ONE_SIDE[None, :])
    truth = truth_of(bow, False)
    assert truth["amplitude"].max() == 0.0
    assert truth["scored"]
    assert not truth_of(bow, True)["scored"]  # a mode grows that has not been seen yet


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
