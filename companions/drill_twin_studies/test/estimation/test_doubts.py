# SPDX-License-Identifier: Apache-2.0
"""Doubts: a model that is wrong is doubted for long, a right model is not, and the output remembers."""

import numpy as np
import pytest

from drill_twin_studies.estimation.doubts import BEGIN, Doubts, Span, told_of_spans
from drill_twin_studies.estimation.innovations import Innovations

SAMPLES = np.array([10.0])
KNOWN, MOVING = np.array([1.0]), np.array([60.0])  # misfits of the first window, of a channel of 100


def windows(doubts, ratios, off=KNOWN, start=0):
    """Channels in doubt after each window of ten samples, whose mean squared innovations have these ratios."""
    found = []
    for window, ratio in enumerate(ratios, start):
        doubts.take(float(window), ratio * SAMPLES, SAMPLES, off, np.array([100.0]))
        found.append(dict(doubts.since))
    return found


def test_a_model_that_is_right_is_not_doubted_in_a_day():
    """In its 86,400 windows, as those of an hour of 24 channels, which know nothing of each other."""
    ratios = np.random.default_rng(7).chisquare(10, (3600, 24)) / 10.0
    doubts, each = Doubts([f"channel {k}" for k in range(24)]), np.ones(24)
    for window, ratio in enumerate(ratios):
        doubts.take(float(window), ratio * SAMPLES, SAMPLES * each, KNOWN * each, 100.0 * each)
        assert not doubts.since


@pytest.mark.parametrize(("ratio", "most"), [(1.8, 25), (3.0, 8), (40.0, 3)])
def test_a_misfit_that_lasts_is_told_the_sooner_the_larger_it_is(ratio, most):
    doubts = Doubts(["torque"])
    windows(doubts, [1.0] * 30)
    found = windows(doubts, [ratio] * 30, start=30)
    assert 30.0 <= found[most - 1]["torque"] <= 30.0 + 0.3 * most
    assert found[0] == {}


def test_one_window_is_no_doubt_and_a_window_without_samples_changes_none():
    doubts = Doubts(["torque"])
    assert not any(windows(doubts, [1.0] * 20 + ([1e6] + [1.0] * 10) * 6))
    windows(doubts, [1.0] * 9 + [9.0] * 3, start=32)
    before = dict(doubts.since)
    doubts.take(44.0, np.zeros(1), np.zeros(1), np.array([np.nan]), np.array([100.0]))
    assert doubts.since == before
    assert 41.0 <= before["torque"] <= 43.0


def test_what_was_wrong_is_believed_only_after_it_has_been_right_for_long():
    doubts = Doubts(["torque"])
    windows(doubts, [1.0] * 12 + [20.0] * 10)
    found = windows(doubts, [1.0] * 120, start=22)
    assert all(found[:95])
    assert not any(found[101:])


@pytest.mark.parametrize(("before", "told"), [(1.0, False), (5.0, True)])
def test_a_jump_that_is_explained_is_forgotten_and_a_model_that_was_wrong_before_is_not(before, told):
    doubts = Doubts(["torque"])
    windows(doubts, [before] * 20 + [40.0] * 2)
    assert doubts.since
    doubts.forget()
    assert bool(doubts.since) is told


@pytest.mark.parametrize(("off", "told"), [(KNOWN, True), (MOVING, False), (np.array([np.nan]), False)])
def test_first_windows_count_where_the_motion_was_known_at_the_start(off, told):
    doubts = Doubts(["torque"])
    found = windows(doubts, [3.0, 30.0, 30.0, 30.0, 30.0] + [1.0] * 20, off)
    assert not any(found[:BEGIN])
    assert bool(found[BEGIN]) is told


def test_the_output_names_spans_of_windows_with_an_alarm():
    doubts = Doubts(["torque"])
    for window in [12, 13, 14, 40, *range(60, 70), 80]:
        doubts.remember(float(window), window + 1.0)
    assert doubts.spans == (Span(12.0, 15.0, 3), Span(40.0, 41.0, 1), Span(60.0, 70.0, 10), Span(80.0, 81.0, 1))
    assert told_of_spans(()) == ""
    assert told_of_spans(doubts.spans).endswith("from 80.0 to 81.0 s (1 windows), and 1 times before")
    assert "from 60.0 to 70.0 s (10 windows)" in told_of_spans(doubts.spans)


@pytest.mark.parametrize("noise", [2.0, 8.0])
def test_surprise_is_one_for_a_right_model_whatever_the_noise_and_the_spread(noise):
    draw, judged = np.random.default_rng(5), Innovations(["torque"])
    shape = np.sin(0.1 * np.pi * np.arange(0.5, 10.0)) ** 2
    ratios = []
    for window in range(60):
        predicted = 5.0 * draw.standard_normal((64, 1, 1)) * shape
        true = 5.0 * draw.standard_normal() * shape
        measured = (true + noise * draw.standard_normal(10))[None]
        judged.take(predicted, measured, np.array([100.0]), np.array([2.0]))
        if window > 20:
            ratios.append(judged.surprises[0] / judged.samples[0])
    assert np.mean(ratios) == pytest.approx(1.0, abs=0.2)


def test_surprise_shows_an_error_that_the_stated_one_hides():
    draw, judged = np.random.default_rng(5), Innovations(["torque"])
    for window in range(40):
        wrong = 2.4 * np.sin(0.7 * (np.arange(10.0) + 10.0 * window))
        measured = (wrong + draw.standard_normal(10))[None]
        judged.take(0.1 * draw.standard_normal((32, 1, 10)), measured, np.array([100.0]), np.array([2.0]))
    assert judged.normalised[0] < 1.5
    assert judged.surprises[0] / judged.samples[0] > 2.0


def test_samples_of_noise_that_is_not_known_yet_do_not_count():
    judged = Innovations(["torque"])
    few = np.full((1, 10), np.nan)
    few[0, 4] = 50.0  # a sample a second
    for _ in range(19):
        judged.take(np.zeros((8, 1, 10)), few, np.array([100.0]), np.array([2.0]))
        assert judged.samples.tolist() == [0]
