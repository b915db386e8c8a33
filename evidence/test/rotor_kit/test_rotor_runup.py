# SPDX-License-Identifier: Apache-2.0
"""The run-up in time against a closed form, steady response, and free vibration after a critical speed."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from drill_twin_evidence.rotor_kit import runup
from drill_twin_evidence.rotor_kit.rig import NAMES, Rigs
from drill_twin_evidence.rotor_kit.runup import RADIANS, maxima, reduced, simulated, steady

# One plane: force 2 (speed^2 - i acceleration) exp(i angle), stiffness (2 pi 30 Hz)^2, damping ratio 0.02.
NATURAL, RATIO = 2 * np.pi * 30.0, 0.02
ONE = (np.array([[2 * RATIO * NATURAL]]), np.zeros((1, 1)), np.array([[NATURAL**2]]))
FORCE = np.array([2.0 + 0j])


@pytest.fixture(autouse=True)
def short_steps(monkeypatch):
    """The kit's step is for modes of 30 Hz among others of 400; one revolution here takes as many steps."""
    monkeypatch.setattr(runup, "LARGEST_STEP", 1e-4)


def test_a_run_up_is_the_one_of_another_integrator():
    start, end, acceleration = 100.0, 260.0, 24.0
    speeds, found, signal, step = simulated(
        ONE, FORCE, np.array([1.0]), start=start, end=end, acceleration=acceleration
    )

    def pushed(time, y):
        speed, angle = start + acceleration * time, start * time + acceleration * time**2 / 2
        pull = (2.0 * (speed**2 - 1j * acceleration) * np.exp(1j * angle)).real
        return [y[1], pull - NATURAL**2 * y[0] - 2 * RATIO * NATURAL * y[1]]

    first = steady(ONE, FORCE, start)[0]
    times = step * np.arange(1, len(signal) + 1)
    exact = solve_ivp(
        pushed, (0, times[-1]), [first.real, (1j * start * first).real], t_eval=times, rtol=1e-8, atol=1e-10
    )
    assert np.abs(signal - exact.y[0]).max() < 2e-3 * np.abs(exact.y[0]).max()
    assert np.abs(found).max() == pytest.approx(np.abs(exact.y[0]).max(), rel=0.03)
    assert np.all(np.diff(speeds) > 0)


def test_a_slow_run_up_is_steady_response():
    speeds, found, _, _ = simulated(ONE, FORCE, np.array([1.0]), start=100.0, end=130.0, acceleration=0.5)
    for at in (10, len(speeds) // 2, -5):
        exact = np.conj(steady(ONE, FORCE, speeds[at])[0])
        assert found[at] == pytest.approx(exact, rel=0.01)


def test_a_fast_run_up_peaks_later_and_lower_than_steady_response():
    # Genta 2005, section 2.9: acceleration moves the peak up in speed and down in height; then motion beats.
    speeds, found, _, _ = simulated(ONE, FORCE, np.array([1.0]), start=100.0, end=320.0, acceleration=24.0)
    height = np.abs(found)
    steady_height = max(abs(steady(ONE, FORCE, speed)[0]) for speed in np.arange(150.0, 230.0, 0.5))
    assert height.max() < 0.95 * steady_height
    assert speeds[height.argmax()] > 1.01 * NATURAL
    assert len(maxima(speeds, height)) == 2


def test_heavy_damping_does_not_blow_the_run_up_up():
    damped = (np.array([[3e4, 0.0], [0.0, 2.0]]), np.zeros((2, 2)), np.diag([1e8, NATURAL**2]))
    _, found, signal, _ = simulated(
        damped, np.array([1.0, 1.0 + 0j]), np.ones(2), start=100.0, end=260.0, acceleration=24.0
    )
    assert np.isfinite(signal).all()
    assert np.abs(found).max() < 1e3


def test_modes_of_the_run_up_hold_the_steady_vector():
    z = np.random.default_rng(8).standard_normal((30, len(NAMES)))
    rigs = Rigs.of(z[Rigs.of(z).possible()])
    rotors, places = rigs.rotors(2), rigs.probe_places()
    whole = rotors.unbalance_response(1200 * RADIANS, places)
    for at in range(len(rigs.values)):
        damping, gyroscopic, stiffness, force, seen = reduced(rotors, at, places)
        for disc in range(2):
            modal = (force[:, 0] - 1j * force[:, 1])[:, disc]
            shown = seen @ steady((damping, gyroscopic, stiffness), modal, 1200 * RADIANS)
            assert np.abs(shown - whole[at, :, :, disc]).max() < 0.02 * np.abs(whole[at, :, :, disc]).max()
