# SPDX-License-Identifier: Apache-2.0
"""The onset is found within half a revolution of the truth, which comes from the noise-free motion."""

import numpy as np
import pytest
from kinematics import BENCH, MARKS, TURN, clock, growth, motion, play
from rotor import Rotor, whirl_of
from scipy.integrate import solve_ivp

from drill_twin import analyze
from drill_twin.whirl import MarkInfo, MotionState


def assert_found(moved, *, mark=0, within=0.5, **how):
    """Checks the onset against the truth; `within` in revolutions. Returns the summary."""
    truth = moved.true_onset(mark)
    assert truth is not None
    analyzer, found = play(moved, **how)
    summary = analyzer.summary()
    assert summary.onset is not None
    speed = abs(moved.top_speed[-1]) / TURN
    assert abs(summary.onset.time_s - truth) * speed < within
    assert summary.onset.time_s <= summary.onset.detected_s
    # Announced once, then never changed; as soon as it was certain.
    announced = [f.onset for f in found if f.onset is not None]
    assert all(onset is summary.onset for onset in announced)
    assert announced[0] is not None
    first = next(f for f in found if f.onset is not None)
    assert first.time_s - summary.onset.detected_s < 0.5 / speed
    return summary


@pytest.mark.parametrize("rate", [20, 100, 200])
@pytest.mark.parametrize("ratio", [0.5, 0.9, 1.5, -0.1, -0.5, -1.9])
@pytest.mark.parametrize("pace", [1.0, 8.0])
def test_growth_from_nothing(rate, ratio, pace):
    moved = motion(clock(rate, 12), bow=0.03, whirl=growth(6.0, 0.05, pace, ratio))
    summary = assert_found(moved)
    assert summary.onset.kind == "asynchronous"
    assert summary.whirl_ratio == pytest.approx(ratio, rel=0.02)
    assert summary.whirl_frequency_hz == pytest.approx(2.0 * ratio, rel=0.02)


def test_two_kilohertz():
    summary = assert_found(motion(clock(2000, 9), bow=0.03, whirl=growth(5.0, 0.05, 2.0, 0.5)), within=0.1)
    assert summary.whirl_ratio == pytest.approx(0.5, rel=0.02)


@pytest.mark.parametrize("seed", range(12))
def test_random_growth_with_noise_jitter_and_drop_outs(seed):
    random = np.random.default_rng(seed)
    rate, speed = random.choice([50, 100, 200]), random.uniform(1.0, 6.0)
    ratio = random.choice([random.uniform(0.2, 0.9), -random.uniform(0.1, 1.0)])
    time = clock(rate, 8.0 + 10.0 / speed, jitter=0.2, seed=seed)
    pace = speed * random.uniform(0.4, 3.0)
    moved = motion(time, speed=speed, bow=0.04, offset=0.1, whirl=growth(8.0, 0.05, pace, ratio), marks=MARKS)
    kept = random.uniform(size=time.size) > 0.1
    summary = assert_found(moved.with_noise(0.01, seed).keep(kept))
    assert np.sign(summary.whirl_ratio) == np.sign(ratio)
    assert summary.whirl_ratio == pytest.approx(ratio, rel=0.05)


@pytest.mark.parametrize(("clearance", "offset"), [(0.03675, 0.00825), (0.0539, 0.1016), (0.5, 0.1)])
def test_other_holes(clearance, offset):
    mark = MarkInfo("near_bit", 22.6, "wall", offset, clearance)
    moved = motion(clock(100, 16), speed=50 / 60, marks=(mark,), bow=0.05, whirl=growth(9.0, 0.05, 1.0, -0.8))
    summary = assert_found(moved.with_noise(0.01, 1))
    assert summary.max_radius_m["near_bit"] == pytest.approx(abs(moved.centre).max(), rel=0.05)


def test_left_hand_rotation():
    summary = assert_found(motion(clock(100, 12), speed=-2.0, bow=0.03, whirl=growth(6.0, 0.05, 2.0, 0.5)))
    assert summary.whirl_ratio == pytest.approx(0.5, rel=0.02)
    assert summary.whirl_frequency_hz == pytest.approx(1.0, rel=0.02)
    assert summary.rotation_rev_s == pytest.approx(-2.0, rel=0.01)


@pytest.mark.parametrize("ratio", [0.5, -0.3])
def test_camera_finds_it_without_spin(ratio):
    moved = motion(clock(100, 14), bow=0.03, whirl=growth(8.0, 0.05, 1.5, ratio), marks=MARKS)
    summary = assert_found(moved.with_noise(0.005, 3), spin=False)
    assert summary.whirl_ratio == pytest.approx(ratio, rel=0.02)


def test_rotation_known_from_the_spin_alone():
    moved = motion(clock(100, 12), whirl=growth(6.0, 0.05, 2.0, 0.5))
    from drill_twin.whirl import Analyzer

    analyzer, positions = Analyzer(moved.marks), moved.positions
    wrapped = np.remainder(moved.spin, TURN)
    for i, stamp in enumerate(moved.stamps.tolist()):
        analyzer.push(stamp, positions[i], wrapped[i], float("nan"))
    assert (analyzer.summary().onset.time_s - moved.true_onset()) * 2.0 == pytest.approx(0.0, abs=0.5)
    assert analyzer.summary().rotation_rev_s == pytest.approx(2.0, rel=0.01)


def test_first_mark_is_named_even_if_another_is_certain_before():
    def whirl(time, angle):
        slow = growth(5.0, 0.05, 1.0, 0.08)(time, angle)
        quick = growth(5.6, 0.05, 2.0, 0.6)(time, angle)
        return np.stack([quick, slow], axis=1)

    pair = (MARKS[0], MARKS[2])
    moved = motion(clock(100, 14), marks=pair, whirl=whirl)
    summary = assert_found(moved, mark=1)
    assert summary.onset.mark == "mark_3"
    assert summary.mark_onset_s["mark_1"] == pytest.approx(moved.true_onset(0), abs=0.25)


@pytest.mark.parametrize("pace", [0.3, 1.0, 4.0])
def test_surge_of_the_synchronous_part(pace):
    time = clock(100, 30)
    bow = np.minimum(0.03 + 0.05 * np.exp(np.clip(pace * (time - 10.0), -50.0, np.log(16.0))), 0.9)
    truth = time[np.argmax(bow > 0.25)]
    analyzer, _ = play(motion(time, bow=bow).with_noise(0.01, 1))
    summary = analyzer.summary()
    assert summary.onset.kind == "synchronous"
    assert (summary.onset.time_s - truth) * 2.0 == pytest.approx(0.0, abs=0.5)
    assert summary.onset.detected_s - truth < 2.0
    assert summary.whirl_ratio == pytest.approx(1.0, rel=0.02)
    assert summary.motion[-1].state is MotionState.SYNCHRONOUS_WHIRL


def test_whirl_of_a_string_that_had_leaned_over_before():
    time = clock(100, 30)
    lean = 0.6 * (1.0 - np.exp(-np.maximum(time - 4.0, 0.0) / 0.2))
    whirl = growth(18.0, 0.05, 2.0, 0.5, limit=0.3)
    assert_found(motion(time, bow=0.03, offset=lean[:, None], whirl=whirl).with_noise(0.005, 1))


@pytest.mark.parametrize(
    "rotor",
    [
        Rotor(),
        Rotor(friction=0.3, limit=1.5),
        Rotor(internal=3.0, limit=1.2),
        Rotor(internal=0.3, limit=0.7, overload=1.1),
        Rotor(start=1e-3 + 0j, eccentricity=1e-3),
        Rotor(overload=3.0, ramp=(0.2, 2.0)),
        Rotor(overload=6.0, ramp=(0.0, 1.0), friction=0.1, limit=1.5),  # thrown out first, turns slowly later
        Rotor(speed=6.0),
    ],
    ids=str,
)
def test_rotor_in_a_hole(rotor):
    moved = whirl_of(rotor, seconds=15.0)
    for force in (True, False):
        summary = assert_found(moved, force=force)
    end = moved.time > 12.0
    rate = np.polyfit(moved.time[end], np.unwrap(np.angle(moved.centre[end, 0])), 1)[0] / TURN
    assert summary.whirl_ratio == pytest.approx(rate / rotor.speed, abs=0.03)
    assert summary.max_radius_m[BENCH.name] == pytest.approx(abs(moved.centre).max(), rel=1e-9)


@pytest.mark.parametrize("wait", [2.0, 8.0, 16.0])
def test_string_that_is_thrown_out_and_turns_later_has_whirled_since(wait):
    """`wait` revolutions long it stands where it was thrown out, longer than the detector's patience."""
    time = clock(100, 30)
    thrown = 0.6 / (1.0 + np.exp(-np.clip(4.0 * (time - 8.0), -50.0, 50.0)))

    def whirl(_time, angle):
        begun = np.interp(8.0, time, angle) + 2.0 * np.pi * wait
        return thrown * np.exp(1j * (0.2 * np.maximum(angle - begun, 0.0) + 0.4))

    summary = assert_found(motion(time, bow=0.02, whirl=whirl).with_noise(0.003, 4))
    assert summary.onset.detected_s - summary.onset.time_s > 0.4 * wait / 2.0


def test_orbit_that_creeps_round():
    """0.011 of the rotation: 90 degrees take 23 revolutions."""
    moved = motion(clock(100, 30), bow=0.02, whirl=growth(8.0, 0.05, 2.0, 0.011))
    assert_found(moved.with_noise(0.002, 5))


@pytest.mark.parametrize("state", ["strikes", "two whirls"])
def test_radius_that_dips_in_a_revolution(state):
    def whirl(time, angle):
        size = np.minimum(0.05 * np.exp(1.2 * (time - 8.0)), 0.7)
        if state == "strikes":  # twice a revolution to 0.4 of the radius, whose root mean square is 0.63 of its largest
            share = (angle / np.pi) % 1.0
            return size / 0.64 * (1.0 - 2.4 * share * (1.0 - share)) * np.exp(0.7j * angle)
        return size * (np.exp(0.4j * angle) + 0.6 * np.exp(-0.9j * angle)) / np.hypot(1.0, 0.6)

    moved = motion(clock(100, 16.0), bow=0.01, whirl=whirl).with_noise(0.01, 4)
    analyzer, _ = play(moved)
    assert analyzer.summary().onset.time_s == pytest.approx(8.0, abs=0.25)  # half a revolution at 2 rev/s


@pytest.mark.parametrize("gap", [0.8, 1.5])
def test_whirl_that_grows_before_a_gap(gap):
    moved = motion(clock(100, 20.0), bow=0.02, whirl=growth(8.0, 0.05, 1.0, 0.4)).with_noise(0.005, 5)
    assert_found(moved.keep((moved.time < 8.3) | (moved.time > 8.3 + gap)))


def test_whirl_after_a_critical_speed_is_not_dated_to_the_passage():
    """A lightly damped string vibrates on after its critical speed, beside its bow; a whirl comes later."""

    def whirl(time, angle):
        step, own, damping = time[1] - time[0], TURN * 2.0, 0.011
        place, pace, path = 0j, 0j, []
        for push in (np.gradient(angle, time) ** 2 * np.exp(1j * angle)).tolist():
            pace += step * (push - 2.0 * damping * own * pace - own**2 * place)
            place += step * pace
            path.append(place)
        return 0.14 / np.abs(path).max() * np.array(path) + growth(31.0, 0.05, 2.0, 0.57)(time, angle)

    moved = motion(clock(400, 36.0), speed=3.5, ramp=18.0, whirl=whirl).with_noise(0.005, 6)
    analyzer, _ = play(moved)
    assert analyzer.summary().onset.time_s == pytest.approx(31.0, abs=0.3)


def test_whirl_is_told_though_a_mark_beyond_its_threshold_has_not_swept_its_angle():
    """The upper mark leans over before the lower one begins to whirl, and turns with it too slowly to be a whirl."""

    def whirl(time, angle):
        lean = 0.3 * (1.0 - np.exp(-np.maximum(time - 7.8, 0.0) / 0.3)) * np.exp(0.004j * angle)
        return np.stack([lean, growth(8.0, 0.05, 2.0, 0.5)(time, angle)], axis=1)

    moved = motion(clock(100, 11), marks=(MARKS[0], MARKS[2]), bow=0.02, whirl=whirl)
    analyzer, _ = play(moved.with_noise(0.002, 3))
    found = analyzer.summary().onset
    assert found.time_s == pytest.approx(7.9, abs=0.25)
    assert found.detected_s < 10.0


def test_a_sudden_start_is_dated_by_the_radius():
    moved = motion(clock(100, 14), bow=0.02, whirl=growth(8.0, 0.5, 200.0, 0.5, limit=0.5)).with_noise(0.002, 3)
    analyzer, _ = play(moved)
    assert analyzer.summary().onset.time_s == pytest.approx(moved.true_onset(), abs=0.04)


@pytest.mark.parametrize("damping", [0.01, 0.05])
@pytest.mark.parametrize("end", [1.5, 2.5, 4.0])
def test_response_in_a_critical_speed_is_synchronous(damping, end):
    """A Jeffcott rotor with unbalance, run up in 20 s: z'' + 2 d w z' + w^2 z = e (Omega^2 - i Omega') exp(i phi)."""
    own, pace, ramp = 2.0 * TURN, end * TURN / 20.0, 20.0
    time = clock(100, 35)

    def turned(at):
        return np.where(at < ramp, 0.5 * pace * at**2, pace * ramp * (at - 0.5 * ramp))

    def slope(at, state):
        speed, gain = pace * min(at, ramp), pace * (at < ramp)
        push = (speed**2 - 1j * gain) * np.exp(1j * turned(at))
        return [state[1], push - 2.0 * damping * own * state[1] - own**2 * state[0]]

    path = solve_ivp(slope, (0.0, 35.0), [0j, 0j], t_eval=time, rtol=1e-7, atol=1e-10).y[0]
    x, y = (0.6 * part / np.abs(path).max() for part in (path.real, path.imag))
    noise = 0.003 * np.random.default_rng(1).normal(size=(2, time.size))
    found = analyze(time, x + noise[0], y + noise[1], pace * np.minimum(time, ramp), clearance=1.0, radius=0.1)
    assert found.summary.onset.kind == "synchronous"
    assert found.onset_s < min(ramp, ramp * 2.0 / end)
