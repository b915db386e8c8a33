# SPDX-License-Identifier: Apache-2.0
"""Rolling along the wall at many times the rotation, up to what the samples can show; synchronous motion told apart.

The motions are made here, of sines; nothing of `drill_twin` makes them.
"""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from drill_twin.whirl import Analyzer, MarkInfo, MotionState
from drill_twin.whirl.history import newest, newest_in

CLEARANCE, TURNS, BEGIN = 0.02, 2.0, 8.0
FEWEST = 2.5
"""Samples in an orbit that are needed."""


def analysed(time, angle, centre, radius, *, noise=0.0, seed=0, spin=True):
    """Analyzer after a wall mark of a string of this radius [m] on a path `centre` [of the clearance]."""
    random = np.random.default_rng(seed)
    z = CLEARANCE * (centre + noise * (random.normal(size=time.size) + 1j * random.normal(size=time.size)))
    z += radius * np.exp(1j * angle)
    analyzer = Analyzer([MarkInfo("mark", 1.0, "wall", radius, CLEARANCE)])
    place = np.stack((z.real, z.imag), axis=-1)[:, None]
    turned = angle[:, None] if spin else None
    analyzer.push_block(np.round(time * 1e9).astype(np.int64), place, turned, np.gradient(angle, time))
    return analyzer


def rolling(ratio, rate, *, noise=0.0, jitter=0.0, seconds=14.0, radius=None, bow=0.01, spin=True, seed=0):
    """Rolling at a ratio to the rotation, after a growth through 5 % of the clearance at `BEGIN`."""
    time = np.arange(round(seconds * rate)) / rate
    if jitter:
        time = np.sort(time + np.random.default_rng(seed + 1).normal(size=time.size) * jitter / rate)
        time -= time[0]
    angle = math.tau * TURNS * time
    grown = 0.05 * np.exp(3.0 * (time - BEGIN))
    grown /= (1.0 + grown**8) ** 0.125
    centre = grown * np.exp(1j * (ratio * angle + 0.4)) + bow * np.exp(1j * (angle + 0.7)) * (grown < 0.9)
    # The radius that rolls without slip, unless another is given.
    return analysed(time, angle, centre, -ratio * CLEARANCE if radius is None else radius, noise=noise, spin=spin)


SHOWN = [
    (ratio, rate)
    for rate in (50.0, 100.0, 400.0)
    for ratio in (-0.3, -1.3, -2.0, -3.0, -4.0, -7.0, -9.5, -16.0, -31.0, -32.0, -47.3, -50.0)
    if abs(ratio) * TURNS * FEWEST < rate
]


@pytest.mark.parametrize(("ratio", "rate"), SHOWN)
@pytest.mark.parametrize("noise", [0.0, 0.02])
def test_rolling_is_found_where_the_samples_show_it(ratio, rate, noise):
    analyzer = rolling(ratio, rate, noise=noise)
    found, summary = analyzer.findings, analyzer.summary()
    assert found.motion is MotionState.ROLLING
    assert found.ratio[0] == pytest.approx(ratio, rel=2e-3, abs=5e-3)
    orbit = analyzer._state.orbit
    assert orbit.radius[0, 0] == pytest.approx(1.0, rel=0.01 + 0.25 * noise)
    assert orbit.contact[0] > 0.95
    assert summary.whirl_ratio == pytest.approx(ratio, rel=5e-3)
    assert summary.onset is not None
    assert summary.onset.kind == "asynchronous"
    assert abs(summary.onset.time_s - BEGIN) * TURNS < 0.5


@pytest.mark.parametrize("ratio", [-5.0, -20.0, -40.0])
def test_jitter_and_a_spin_that_is_not_measured(ratio):
    for more in ({"jitter": 0.2}, {"spin": False, "bow": 0.0}):
        analyzer = rolling(ratio, 400.0, **more)
        found = analyzer.findings
        assert found.motion is MotionState.ROLLING, more
        assert found.ratio[0] == pytest.approx(ratio, rel=1e-3)
        assert analyzer._state.orbit.radius[0, 0] == pytest.approx(1.0, rel=0.02)


def test_a_slow_part_beside_a_fast_orbit_is_kept():
    """A string that rolls about a place that itself goes round: both are in its distance from the axis."""
    time = np.arange(4800) / 400.0
    angle = math.tau * TURNS * time
    centre = 0.6 * np.exp(-20j * angle) + 0.3 * np.exp(0.3j * angle)
    analyzer = analysed(time, angle, centre, 20.0 * CLEARANCE)
    assert analyzer.findings.ratio[0] == pytest.approx(-20.0, rel=0.01)
    history = analyzer._state.history
    window = newest(history, newest_in(history, 2.0))
    turned = math.tau * TURNS * history.time[window]
    true = 0.6 * np.exp(-20j * turned) + 0.3 * np.exp(0.3j * turned)
    assert np.abs(history.vector[window, 0, 0] / CLEARANCE - true).max() < 0.03


@pytest.mark.parametrize("ratio", [-4.0, -5.0, -6.0, -8.0, -9.0, -10.0])
@pytest.mark.parametrize("radius", [None, 0.002])
def test_too_few_samples_are_told(ratio, radius):
    """20 Hz at 2 rev/s: from -5 on the motion looks like another, be it a rotation about a fixed axis."""
    analyzer = rolling(ratio, 20.0, radius=radius)
    found, summary = analyzer.findings, analyzer.summary()
    told = "not definite: 10.0 samples in a revolution" in found.criterion[0]
    assert told or found.motion is MotionState.NOT_OBSERVABLE
    assert analyzer._state.carrier.definite[0] < 0.7
    assert any(note.startswith("not definite") for note in summary.notes)
    assert summary.onset is None or (summary.onset.confidence < 0.7 and "not definite" in summary.onset.criterion)


def test_an_orbit_at_half_the_sample_rate_is_not_observable():
    for ratio, rate in ((-5.0, 20.0), (-24.0, 100.0)):
        assert rolling(ratio, rate).findings.motion is MotionState.NOT_OBSERVABLE


@pytest.mark.parametrize(("whirls", "told"), [(True, True), (False, False)])
def test_rolling_that_samples_cannot_show_is_told_of_a_mark_that_whirls(whirls, told):
    """Blade of a stabiliser that would roll at -97 times the rotation: on the low side throughout, or in a whirl."""
    time = np.arange(2000) / 100.0
    angle = math.tau * TURNS * time
    low = np.full(time.size, 0.98 + 0j)
    centre = 0.9 * np.exp(0.4j * angle) * np.clip(time - 4.0, 0.0, 1.0) if whirls else low
    summary = analysed(time, angle, centre, 97.0 * CLEARANCE).summary()
    assert any("rolling, at -97.0 times the rotation" in note for note in summary.notes) is told
    assert (summary.onset is not None) is whirls


def test_sufficient_samples_are_definite():
    analyzer = rolling(-10.0, 100.0)
    assert "not definite" not in analyzer.findings.criterion[0]
    assert not any("not definite" in note for note in analyzer.summary().notes)
    assert analyzer._state.carrier.definite[0] > 0.9


@pytest.mark.parametrize("seconds", [0.1, 1.0, 20.0])
def test_unbalance_that_grows_is_synchronous(seconds):
    time = np.arange(3000) / 50.0
    angle = math.tau * TURNS * time
    size = 0.02 + 0.6 * np.clip((time - 15.0) / seconds, 0.0, 1.0)
    summary = analysed(time, angle, size * np.exp(1j * (angle + 0.5)), 0.01).summary()
    assert summary.onset is not None
    assert summary.onset.kind == "synchronous"
    assert [period.state for period in summary.motion[1:]] == [MotionState.SYNCHRONOUS_WHIRL]


@pytest.mark.parametrize("peak", [0.3, 0.8])
@pytest.mark.parametrize("damping", [0.05, 0.1])
def test_a_run_up_through_a_critical_speed_is_synchronous(damping, peak):
    """A Jeffcott rotor of 2 Hz from 0.5 to 4 rev/s in 40 s: z'' + 2 D w z' + w^2 z = e W^2 exp(i angle)."""
    time, own = np.arange(6500) / 100.0, math.tau * 2.0
    speed = math.tau * (0.5 + 3.5 * np.clip((time - 15.0) / 40.0, 0.0, 1.0))
    angle = np.concatenate(([0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1])) / 100.0))

    def rate(t, y):
        push = 2.0 * damping * peak * np.interp(t, time, speed) ** 2 * np.exp(1j * np.interp(t, time, angle))
        return [y[1], push - 2.0 * damping * own * y[1] - own * own * y[0]]

    solved = solve_ivp(rate, (0.0, time[-1]), [0j, 0j], t_eval=time, rtol=1e-6, atol=1e-8, max_step=0.02)
    summary = analysed(time, angle, solved.y[0], 0.01).summary()
    assert summary.onset is None or summary.onset.kind == "synchronous"
    states = {period.state for period in summary.motion}
    assert states <= {MotionState.FIXED_AXIS, MotionState.SYNCHRONOUS_WHIRL, MotionState.AT_REST}


@pytest.mark.parametrize("ratio", [0.8, 0.9, 1.15])
def test_self_excited_whirl_near_the_rotation_is_asynchronous(ratio):
    summary = rolling(ratio, 50.0, seconds=24.0, radius=0.01).summary()
    assert summary.onset is not None
    assert summary.onset.kind == "asynchronous"
    assert abs(summary.onset.time_s - BEGIN) * TURNS < 0.5
    assert summary.motion[-1].state is MotionState.FORWARD_WHIRL
