# SPDX-License-Identifier: Apache-2.0
"""Each kind of motion is named on draws that nothing was tuned on, and what does not whirl has no onset."""

import numpy as np
import pytest
from kinds import EXPECTED, drawn, judged
from kinematics import clock, growth, motion, play

from drill_twin.core.compile.jit import as_python
from drill_twin.whirl import MotionState
from drill_twin.whirl.history import BINS, CAPACITY, new_history, newest_in
from drill_twin.whirl.orbit.two_lines import find_lines

SEEDS = range(900000, 900006)
ALLOWED = {"plane once a turn": 2, "two whirls": 2, "impacts": 1, "creeping": 1}
"""Draws of six that may have another name; none may whirl, or not, against the truth but of the first."""


@pytest.mark.parametrize("kind", EXPECTED)
def test_kind_of_drawn_motions(kind):
    rows = [judged(kind, seed) for seed in SEEDS]
    assert sum(not right for _, right, *_ in rows) <= ALLOWED.get(kind, 0), rows
    assert sum(not onset for onset, *_ in rows) <= (kind == "plane once a turn"), rows


@pytest.mark.parametrize("kind", ["two whirls", "irregular", "forward"])
def test_irregular_share_of_the_motion(kind):
    for seed in SEEDS:
        summary = drawn(kind, seed).analysed().summary()
        if summary.lasting_motion is MotionState.IRREGULAR:
            assert summary.irregular_share > 0.2
        elif kind == "forward":
            assert summary.irregular_share < 0.2
    assert drawn("still", 900000).analysed().summary().irregular_share is None


def test_the_stronger_of_two_whirls_gives_the_frequency():
    """Its ratio, not that of the mean angle."""
    record = next(r for r in (drawn("two whirls", seed) for seed in range(900000, 900050)) if not r.mark.inclined)
    summary = record.analysed().summary()
    assert summary.whirl_ratio == pytest.approx(record.ratio, abs=0.03)
    assert summary.irregular_share < 0.2


def test_two_lines_of_a_known_sum():
    """Rates, radii and what is left of two turns and noise."""
    seen = np.linspace(0.0, 6.0, 192)
    draw = np.random.default_rng(3)
    noise = 0.1 * (draw.normal(size=192) + 1j * draw.normal(size=192))
    at = 191 + CAPACITY + 1
    time, vector = np.zeros(2 * CAPACITY), np.zeros((2 * CAPACITY, 3, 1), complex)
    time[at - 192 : at] = seen
    vector[at - 192 : at, 0, 0] = np.exp(2.1j * seen) + 0.4 * np.exp(-5.3j * seen + 1.0j) + noise
    history = new_history(1)._replace(time=time, vector=vector, appended=np.array([192]))
    lines, work = np.empty((2, 2)), np.zeros((2, 192), complex)
    left = as_python(find_lines)(history, 0, 0.0, work[0], work[1], lines)
    assert lines[:, 0] == pytest.approx([2.1, -5.3], abs=0.02)
    assert lines[:, 1] == pytest.approx([1.0, 0.4], abs=0.03)
    assert left == pytest.approx(0.02 / 1.18, abs=0.01)


@pytest.mark.parametrize(("rate", "noise"), [(50, 0.03), (200, 0.03), (1000, 0.03), (1000, 0.01)])
@pytest.mark.parametrize("radius", [0.8, 0.88, 0.92])
def test_noise_is_no_strike(rate, noise, radius):
    """Single samples of an orbit beside the wall reach it by noise."""
    moved = motion(clock(rate, 16), whirl=growth(5.0, 0.05, 1.5, 0.4, limit=radius)).with_noise(noise, 1)
    assert play(moved)[0].summary().lasting_motion is MotionState.FORWARD_WHIRL


@pytest.mark.parametrize("ratio", [-0.6, 0.5])
def test_strikes_shorter_than_a_bin(ratio):
    """Three deep hops a revolution touch the wall for less than 1/16 of it."""

    def whirl(time, angle):
        share = (1.5 * angle / np.pi) % 1.0
        return (
            np.minimum(0.05 * np.exp(1.2 * (time - 5.0)), 1.0)
            * (1.0 - 2.0 * share * (1.0 - share))
            * np.exp(1j * ratio * angle)
        )

    moved = motion(clock(200, 16), whirl=whirl).with_noise(0.01, 2)
    assert play(moved)[0].summary().lasting_motion is MotionState.IMPACTS


@pytest.mark.parametrize("revolutions", [0.5, 1.0, 2.0, 4.0])
def test_newest_bins_are_those_that_numpy_counts(revolutions):
    """Bins of uneven places, some of them at the bound."""
    draw = np.random.default_rng(5)
    places = np.cumsum(draw.integers(1, 4, size=160) / (2.0 * BINS))
    at = 159 + CAPACITY + 1
    history = new_history(1)._replace(appended=np.array([160]), length=np.array([160]))
    history.revolutions[at - 160 : at] = places
    least = places[-1] - revolutions + 0.5 / BINS
    assert newest_in(history, revolutions) == 160 - np.searchsorted(places, least) < 160
