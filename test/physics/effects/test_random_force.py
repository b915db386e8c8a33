# SPDX-License-Identifier: Apache-2.0
"""The random force: what it is, how a mode answers it, and that it is the same in every run of a seed."""

import numpy as np
import pytest
from rod_scenes import AT_REST, FIRST, LENGTH, LINE_MASS, first_mode, quiet_scene
from scipy.integrate import trapezoid

from drill_twin.dynamics.twin.twin import Twin


def test_the_force_itself() -> None:
    """A soft string in thick drag moves at f / c: mean square, correlation along the string and in time, within 5 %.

    Over six seeds of 16 s, seven correlation lengths long: some 5000 independent values.
    """
    drag, rms, time, length = 200.0, 3.0, 0.05, 0.7
    runs = []
    for seed in range(1, 7):
        force = {"rms": rms, "correlation_time": time, "correlation_length": length, "seed": seed}
        effects = {"drag": {"linear": drag}, "random_force": force}
        soft = ({"youngs_modulus": 1e3},)
        twin = Twin(quiet_scene(effects, form="lateral", sections=soft, step=5e-3, elements=25))
        frames = [twin.advance(AT_REST, 0.02).velocities[3:-3, :2] @ [1.0, 1.0j] for _ in range(800)]
        runs.append(np.array(frames) * drag / rms)
    f = np.array(runs)
    assert abs(f.mean()) < 0.03
    assert np.mean(np.abs(f) ** 2) == pytest.approx(1.0, abs=0.05)
    for apart in (2, 5):
        along = np.mean(f[:, :, apart:] * f[:, :, :-apart].conj())
        assert along == pytest.approx(np.exp(-((0.2 * apart / length) ** 2) / 2.0), abs=0.05)
        later = np.mean(f[:, apart:] * f[:, :-apart].conj())
        assert later == pytest.approx(np.exp(-((0.02 * apart / time) ** 2) / 2.0), abs=0.05)


def test_how_a_mode_answers() -> None:
    """Mean square of the first mode: int S(w) |H(w)|^2 dw, H = 1 / (m (w_1^2 - w^2) + i c w), S Gaussian.

    Over twelve seeds of 60 s, which determine it to about 2.5 %; within three times that.
    """
    rms, time, length, drag = 0.02, 0.15, 0.8, 0.4 * LINE_MASS * FIRST
    arc = np.linspace(0.0, LENGTH, 501)
    shape = first_mode(arc)[0]
    norm = trapezoid(shape**2, arc)
    correlation = np.exp(-(((arc[:, None] - arc) / length) ** 2) / 2.0)
    share = shape @ correlation @ shape * (arc[1] / norm) ** 2
    w = np.linspace(-60.0, 60.0, 20001)
    spectrum = time / np.sqrt(2.0 * np.pi) * np.exp(-((w * time) ** 2) / 2.0)
    response = np.abs(LINE_MASS * (FIRST**2 - w**2) + 1j * drag * w) ** -2
    exact = rms**2 * share * trapezoid(spectrum * response, w)
    squares = []
    for seed in range(1, 13):
        force = {"rms": rms, "correlation_time": time, "correlation_length": length, "seed": seed}
        effects = {"drag": {"linear": drag}, "random_force": force}
        twin = Twin(quiet_scene(effects, form="lateral", step=0.01, elements=16, frame_rate=25.0))
        weights = first_mode(twin.rod.arc)[0] * twin.rod.length[0] / norm
        places = np.array([twin.advance(AT_REST, 0.04).positions[:, :2] @ [1.0, 1.0j] for _ in range(1750)])
        squares.append(np.mean(np.abs(places[250:] @ weights) ** 2))
    assert np.mean(squares) == pytest.approx(exact, rel=0.075)


@pytest.mark.parametrize("form", ["lateral", pytest.param("spatial", marks=pytest.mark.long)])
def test_frames_do_not_change_it(form: str) -> None:
    """The same seed gives the same motion whatever the frame rate, and all but the same for half the step."""
    force = {"rms": 0.1, "correlation_time": 0.2, "correlation_length": 1.0}

    def end(frame: float, step: float, seed: int = 1) -> np.ndarray:
        effects = {"random_force": force | {"seed": seed}}
        twin = Twin(quiet_scene(effects, form=form, step=step, elements=16, frame_rate=20.0))
        for _ in range(round(2.0 / frame)):
            last = twin.advance(AT_REST, frame)
        return last.positions[:, :2].copy()

    often, rarely, finely, other = end(0.01, 0.01), end(0.05, 0.01), end(0.05, 0.005), end(0.05, 0.01, seed=2)
    size = np.abs(often).max()
    assert often == pytest.approx(rarely, abs=1e-7 * size)
    assert often == pytest.approx(finely, abs=2e-2 * size)
    assert np.abs(often - other).max() > 0.1 * size
