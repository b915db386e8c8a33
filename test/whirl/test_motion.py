# SPDX-License-Identifier: Apache-2.0
"""Motion states: each of the paper's seven from labelled motion, with its criterion and hysteresis."""

from dataclasses import replace

import numpy as np
import pytest
from kinematics import BENCH, MARKS, clock, growth, motion, play

from drill_twin.whirl import MarkInfo, MotionState

THREE = tuple(MarkInfo(name, height, "wall", 0.00825, 0.08175) for name, height in (("a", 4.0), ("b", 3.0), ("c", 2.0)))


def shaped(shape, ratio=0.5, level=0.7):
    """Growth of a shape [complex, of the largest] at a ratio of the rotation."""
    grow = growth(5.0, 0.05, 3.0, ratio, limit=level)
    return lambda time, angle: grow(time, angle)[:, None] * np.asarray(shape)


def wander(time, angle):
    """A motion with power at many ratios."""
    random = np.random.default_rng(4)
    lines = sum(
        np.exp(1j * (p * angle + a)) for p, a in zip(random.uniform(-1.5, 2.5, 6), random.uniform(0, 6, 6), strict=True)
    )
    return 0.2 * lines / (1.0 + np.exp(-3.0 * (time - 5.0)))


CASES = {
    MotionState.FIXED_AXIS: {"bow": 0.2, "offset": 0.4},
    MotionState.FORWARD_WHIRL: {"bow": 0.03, "whirl": shaped([0.8, 1.0, 0.9])},
    MotionState.ROLLING: {"whirl": shaped([1.0, 1.0, 1.0], ratio=BENCH.rolling_ratio, level=1.0)},
    MotionState.SECOND_BENDING: {"bow": 0.03, "whirl": shaped([1.0, 0.1, -0.8])},
    MotionState.IRREGULAR: {"whirl": wander},
    MotionState.BACKWARD_WHIRL: {"bow": 0.03, "whirl": shaped([0.8, 1.0, 0.9], ratio=-0.3)},
    MotionState.SPIRAL: {"bow": 0.03, "whirl": shaped(np.exp(1j * np.arange(3)))},
}


@pytest.mark.parametrize("state", CASES, ids=lambda state: state.value)
@pytest.mark.parametrize("rate", [50, 200])
def test_each_state_from_its_label(state, rate):
    moved = motion(clock(rate, 20), marks=THREE, **CASES[state]).with_noise(0.01, 5)
    analyzer, found = play(moved)
    late = [f.motion for f in found if f.time_s > 10.0]
    share = 0.7 if state is MotionState.IRREGULAR else 0.95  # sums of lines are regular for a while
    assert late.count(state) > share * len(late)
    assert found[-1].motion_criterion
    if state is MotionState.IRREGULAR:
        texts = [of.motion_criterion for of in found if of.motion is state]
        assert all("rough for " in text and "(coherence below 0.85 or unevenness above 0.3)" in text for text in texts)
    summary = analyzer.summary()
    assert summary.motion[-1].state is state
    starts = [period.start_s for period in summary.motion]
    assert starts == sorted(starts)
    assert starts[0] == 0.0


def test_at_rest_then_turning_then_at_rest():
    time = clock(100, 30)
    moved = motion(time, bow=0.1)
    speed = np.where((time > 5.0) & (time < 20.0), 4.0 * np.pi, 0.0)
    angle = np.concatenate(([0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(time))))
    rest = 0.1 * BENCH.clearance * np.exp(1j * angle)[:, None]
    moved = type(moved)(moved.marks, time, angle[:, None], speed, moved.whirl, rest, moved.noise)
    analyzer, _ = play(moved)
    periods = [(period.state, period.start_s) for period in analyzer.summary().motion]
    assert [state for state, _ in periods] == [MotionState.AT_REST, MotionState.FIXED_AXIS, MotionState.AT_REST]
    assert [start for _, start in periods] == pytest.approx(
        [0.0, 5.0, 20.0], abs=2.0
    )  # a rotation too slow to turn a bin takes time to see


def test_whirl_that_ends_and_begins_again():
    time = clock(100, 40)
    level = np.select([time < 6.0, time < 16.0, time < 28.0], [0.0, 0.5, 0.0], 0.5)
    smooth = np.convolve(level, np.ones(100) / 100, mode="same")
    moved = motion(time, bow=0.03, whirl=lambda _t, angle: smooth * np.exp(0.4j * angle)).with_noise(0.005, 1)
    analyzer, _ = play(moved)
    summary = analyzer.summary()
    assert [period.state for period in summary.motion if period.state is not MotionState.AT_REST] == [
        MotionState.FIXED_AXIS,
        MotionState.FORWARD_WHIRL,
        MotionState.FIXED_AXIS,
        MotionState.FORWARD_WHIRL,
    ]
    assert summary.onset.time_s == pytest.approx(moved.true_onset(), abs=0.25)


def test_marks_have_states_of_their_own():
    def whirl(time, angle):
        grow = growth(5.0, 0.05, 3.0, 0.5)(time, angle)
        return np.stack([0.0 * grow, grow], axis=1)

    analyzer, found = play(motion(clock(100, 14), marks=MARKS[1:3], bow=0.03, whirl=whirl).with_noise(0.005, 2))
    assert found[-1].state == (MotionState.FIXED_AXIS, MotionState.FORWARD_WHIRL)
    assert found[-1].motion is MotionState.FORWARD_WHIRL
    assert analyzer.summary().mark_onset_s["mark_2"] is None
    assert analyzer.summary().mark_motion["mark_3"][-1].state is MotionState.FORWARD_WHIRL


def test_noise_about_a_threshold_does_not_flicker():
    moved = motion(clock(100, 60), whirl=lambda _t, angle: 0.05 * np.exp(0.5j * angle)).with_noise(0.02, 3)
    analyzer, _ = play(moved)
    assert len(analyzer.summary().motion) <= 4


def pressed(moved):
    """The same motion with a wall force all the time."""
    return replace(moved, contact=np.ones_like(moved.spin))


def test_contact_comes_from_the_force_where_it_is_given():
    moved = motion(clock(100, 14), whirl=shaped([1.0], ratio=BENCH.rolling_ratio, level=0.6))
    analyzer, found = play(pressed(moved), force=True)
    assert analyzer._state.orbit.contact[0] == 1.0
    assert found[-1].motion is MotionState.ROLLING
    analyzer, found = play(moved)
    assert analyzer._state.orbit.contact[0] == 0.0
    assert found[-1].motion is MotionState.BACKWARD_WHIRL


@pytest.mark.parametrize(("ratio", "state"), [(0.5, MotionState.FORWARD_WHIRL), (-0.5, MotionState.BACKWARD_WHIRL)])
def test_what_slides_along_the_wall_does_not_roll(ratio, state):
    """Pure rolling is backward, at -r_o / clearance = -0.1 here."""
    _, found = play(pressed(motion(clock(100, 14), whirl=shaped([1.0], ratio=ratio, level=1.0))), force=True)
    assert found[-1].motion is state
    assert "sliding along the wall, in contact 100 %" in found[-1].motion_criterion


@pytest.mark.parametrize(
    ("ratio", "state"), [(-0.07, MotionState.CREEPING), (-0.03, MotionState.CREEPING), (-1.88, MotionState.ROLLING)]
)
def test_creep_along_the_wall_is_told_from_rolling(ratio, state):
    """Ratios of a collar that rolls at -1.878: 0.03 g and 2.6 g."""
    mark = MarkInfo("m", 2.0, "wall", 0.1016, 0.0541)
    _, found = play(pressed(motion(clock(100, 40), marks=(mark,), whirl=shaped([1.0], ratio=ratio, level=1.0))))
    assert found[-1].motion is state
    assert f"slip {abs(1.0 + ratio / 1.878):.2f} of the rim speed" in found[-1].motion_criterion


def test_any_backward_whirl_in_contact_rolls_where_the_rim_is_not_known():
    mark = MarkInfo("m", 2.0, "centre", 0.0, 0.08175)
    _, found = play(pressed(motion(clock(100, 14), marks=(mark,), whirl=shaped([1.0], ratio=-0.5))), force=True)
    assert found[-1].motion is MotionState.ROLLING


def test_planarity_of_a_helix():
    analyzer, _ = play(
        motion(clock(100, 14), marks=THREE, whirl=shaped(np.array([0.6, 1.0, 0.8]) * np.exp(0.8j * np.arange(3))))
    )
    assert analyzer._state.shape.planarity[0] < 0.7


def test_words_are_those_of_the_settled_motion():
    analyzer, found = play(motion(clock(100, 30), bow=0.1, whirl=shaped([1.0])).with_noise(0.005, 2))
    fixed, whirl = analyzer.summary().motion
    assert "asynchronous radius 0." in fixed.criterion
    assert "synchronous 10." in fixed.criterion or "synchronous 9." in fixed.criterion
    assert "radius 6" in whirl.criterion or "radius 7" in whirl.criterion
    assert found[1].motion_criterion == "no rotation seen yet" or "less than a revolution" in found[20].motion_criterion


def test_change_between_two_whirls_is_dated_to_when_it_came():
    time = clock(100, 40)

    def whirl(_t, angle):
        begun = np.interp(20.0, time, angle)
        turned = np.where(time < 20.0, 0.5 * angle, 0.5 * begun - 0.4 * (angle - begun))
        return 0.6 / (1.0 + np.exp(-3.0 * (time - 6.0))) * np.exp(1j * turned)

    analyzer, _ = play(motion(time, bow=0.02, whirl=whirl).with_noise(0.005, 3))
    states = [(period.state, period.start_s) for period in analyzer.summary().motion]
    assert [state for state, _ in states[-2:]] == [MotionState.FORWARD_WHIRL, MotionState.BACKWARD_WHIRL]
    assert states[-1][1] == pytest.approx(20.0, abs=0.3)
