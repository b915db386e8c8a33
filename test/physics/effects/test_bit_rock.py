# SPDX-License-Identifier: Apache-2.0
"""Bit on rock: rate of penetration and torque, weight at the bit or at the top, lifting off, and the random law."""

import numpy as np
import pytest
from end_scenes import steel
from pydantic import ValidationError
from rod_scenes import rod_scene

from drill_twin.dynamics.twin.frame import RigState
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.physics.effects.random_draws import MOST_SCATTER, random_matrix
from drill_twin.physics.model import SPIN
from drill_twin.scene import load_scene
from drill_twin.scene.set_points.command import Command
from drill_twin_evidence.verify.scenes import drilled

SPEED = 100.0 * np.pi / 30.0
A1, A2, A3, A4, A5, E = 3.429e-3, 5.672e-8, 1.374e-4, 9.537e6, 1.475e3, 2.0  # Ritto, Soize and Sampaio 2009
Z = SPEED / np.hypot(SPEED, E)
ROCK = {"rock_stiffness": 1e8}


def drill(
    weight: float, *, seconds: float = 1.0, at: str = "bit", speed: float = SPEED, **law
) -> tuple[Twin, RigState]:
    """A twin that has drilled for so long, up from standstill in the first 0.2 s, and the mean of its next 0.1 s."""
    law = law | (ROCK if at == "top" else {})
    twin = Twin(steel({"bit_cutting": law}, at=at, weight_on_bit=weight))
    twin.advance(Command(weight, speed), 0.2)
    twin.advance(Command(weight, speed), seconds)
    return twin, twin.advance(Command(weight, speed), 0.1).rig


def mean_law(rate: float) -> tuple[float, float]:
    """Weight [N] and torque [N m] at a rate of penetration [m/s] and 100 rpm."""
    weight = rate / (A2 * Z**2) - A3 * SPEED / (A2 * Z) + A1 / A2
    return weight, rate * A4 * Z**2 / SPEED + A5 * Z


def test_below_its_threshold_the_bit_rubs_and_does_not_drill():
    """No depth below a1/a2 - a3 sqrt(w^2 + e^2) / a2 = 34.7 kN; the rubbing torque falls with the weight."""
    twin, rig = drill(20e3, at="top")
    assert drilled(twin) == 0.0
    assert rig.bit_torque == pytest.approx(-A5 * Z * 20e3 / mean_law(0.0)[0], rel=1e-3)
    assert rig.bit_force == pytest.approx(20e3, rel=1e-3)


@pytest.mark.parametrize("at", ["bit", "top"])
@pytest.mark.parametrize("weight", [20e3, 100e3])
def test_a_bit_that_turns_backwards_rubs_and_does_not_cut(at, weight):
    """a5 Z against the turning, for 20 kN the share of it below the threshold; the weight is carried all the same."""
    twin, rig = drill(weight, at=at, speed=-SPEED)
    assert drilled(twin) == 0.0
    assert rig.bit_torque == pytest.approx(A5 * Z * min(weight / mean_law(0.0)[0], 1.0), rel=1e-3)
    assert rig.bit_force == pytest.approx(weight, rel=1e-3)


@pytest.mark.parametrize("at", ["bit", "top"])
@pytest.mark.parametrize("law", [{}, {"dispersion": 0.1, "seed": 2}, {"dispersion": 0.1, "rubbing": 0, "digging": 0}])
def test_a_bit_turns_back_and_forth_without_a_step_that_is_cut(at, law):
    """Through rest the torque goes smoothly, and forwards alone it drills; a random matrix mixes nothing where the law
    has no torque."""
    twin, _ = drill(100e3, at=at, seconds=0.3, **law)
    depths = [drilled(twin)]
    for speed in (-SPEED, -SPEED, SPEED):
        frames = [twin.advance(Command(100e3, speed), 0.05) for _ in range(8)]
        assert sum(frame.stats.cut_steps for frame in frames) == 0
        assert frames[-1].rig.bit_torque * speed <= 0.0
        depths.append(drilled(twin))
    assert depths[0] > 0.0
    assert depths[2] == depths[1]
    assert depths[3] > depths[2]


def test_the_bit_lifts_off_and_comes_down_again():
    """Pulled at the top the bit leaves the rock: no weight, no torque; the rock has no hands."""
    twin, _ = drill(60e3, at="top", seconds=0.2)
    depth = drilled(twin)
    lifted = [twin.advance(Command(-20e3, SPEED), 0.02).rig for _ in range(10)]
    assert lifted[-1].bit_force == 0.0
    assert lifted[-1].bit_torque == 0.0
    assert twin.unknowns[0][0, 2] > twin.dynamics.parameters.bit_cutting.memory[0] + 1e-3
    high = drilled(twin)
    twin.advance(Command(60e3, SPEED), 0.02)

    def momentum() -> float:
        nodes = twin.unknowns[1][:, 2]
        return float((nodes[1:] + nodes[:-1]).mean() / 2.0 * 10.0 * twin.rod.line_mass[0])

    began = momentum()
    back = [twin.advance(Command(60e3, SPEED), 0.02).rig.bit_force for _ in range(100)]
    assert high - depth < 1e-4 < drilled(twin) - high
    assert min(back) == 0.0
    # it comes down, cuts and bounces: what the rock gave is what the momentum took
    assert np.sum(back) * 0.02 - 60e3 * 2.0 == pytest.approx(momentum() - began, abs=0.01 * 60e3 * 2.0)


def test_the_rig_tells_depth_and_rate_of_penetration():
    twin, _ = drill(60e3, at="top", seconds=0.2)
    before = drilled(twin)
    rig = twin.advance(Command(60e3, SPEED), 0.5).rig
    assert rig.drilled == drilled(twin) > before
    assert rig.rate_of_penetration == pytest.approx((drilled(twin) - before) / 0.5, rel=1e-9)
    other = Twin(load_scene("pa6_bench")).advance(Command(10.0, SPEED), 0.1).rig
    assert (other.drilled, other.rate_of_penetration) == (0.0, 0.0)


def random_rate(drawn: np.ndarray, weight: float) -> float:
    """Rate [m/s] at which G11 W + G12 sqrt(W T w / x) is the weight, from fast; W, T of the mean law at x."""
    rates = np.logspace(0.0, -9.0, 200001)
    force, torque = mean_law(rates)
    found = drawn[0, 0] * force + drawn[0, 1] * np.sqrt(force * torque * SPEED / rates)
    below = np.flatnonzero(found < weight)
    return float(rates[below[0]]) if below.size else 0.0


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("at", ["bit", "top"])
def test_one_draw_of_the_random_law(seed, at):
    """F = A^1/2 G A^1/2 (x, w) with A = diag(W / x, T / w) of the mean law: rate and torque as the draw says."""
    twin, rig = drill(100e3, at=at, dispersion=0.1, seed=seed, seconds=2.0)
    law = twin.dynamics.parameters.bit_cutting
    drawn = np.array([[law.axial, law.mixed], [law.mixed, law.turning]])
    assert not np.allclose(drawn, np.eye(2), atol=1e-3)
    before = drilled(twin)
    twin.advance(Command(100e3, SPEED), 0.1)
    rate = (drilled(twin) - before) / 0.1
    exact = random_rate(drawn, 100e3)
    assert rate == pytest.approx(exact, rel=1e-3, abs=1e-12)
    force, torque = mean_law(exact)
    share = 1.0 if exact > 0.0 else min(100e3 / (drawn[0, 0] * force), 1.0)
    turning = drawn[1, 1] * torque + drawn[0, 1] * np.sqrt(force * torque * exact / SPEED)
    assert rig.bit_torque == pytest.approx(-share * turning, rel=1e-3)


def test_without_dispersion_the_random_law_is_the_mean_law():
    """delta -> 0 recovers the deterministic run; equal seeds give equal runs, others differ."""

    def depth(**law):
        return drilled(drill(100e3, seconds=0.3, **law)[0])

    still, faint = depth(), depth(dispersion=1e-5, seed=3)
    assert faint != still
    assert faint == pytest.approx(still, rel=1e-3)
    assert depth(dispersion=0.05, seed=5) == depth(dispersion=0.05, seed=5)
    assert depth(dispersion=0.05, seed=5) != depth(dispersion=0.05, seed=6)


@pytest.mark.parametrize("dispersion", [0.1, 0.4])
def test_the_germ_has_mean_one_and_the_dispersion_asked_for(dispersion):
    """E[G] = I and E[|G - I|^2] = 2 delta^2 over 1e4 draws, positive definite each (Soize 2000)."""
    random = np.random.default_rng(4)
    draws = np.array([random_matrix(dispersion, random) for _ in range(10_000)])
    # the sample mean scatters by delta / sqrt(3 * 10^4) off the diagonal and sqrt(2) times that on it
    assert draws.mean(0) == pytest.approx(np.eye(2), abs=5.0 * dispersion * np.sqrt(2.0 / 3e4))
    assert np.sqrt(np.sum((draws - np.eye(2)) ** 2, (1, 2)).mean() / 2.0) == pytest.approx(dispersion, rel=0.03)
    assert np.linalg.eigvalsh(draws).min() > 0.0
    assert np.sqrt(3.0 / 7.0) == MOST_SCATTER


REFUSED = [
    ({"bit_cutting": {"dispersion": 0.66}}, "bit", "sqrt(3/7)"),
    ({"bit_cutting": {"seed": -1}}, "bit", "expected a whole number from 0"),
    ({"bit_cutting": {}}, "top", "expected a stiffness such as"),
    ({"bit_cutting": ROCK}, "bit", "such a weight needs no rock"),
    ({"rock_floor": {"stiffness": 1e8}}, "bit", "needs no rock to support it"),
    ({"rock_floor": {"stiffness": 0.0}}, "top", "above 0 N/m"),
    ({"bit_cutting": {}, "bit_torque_tanh": {}}, "bit", "one law of the rock's torque on the bit, found"),
    ({"bit_cutting": ROCK, "rock_floor": {"stiffness": 1e8}}, "top", "one law of the rock's weight"),
    (
        {"bit_torque_stribeck": {"radius": 0.1, "sliding": 0.5, "sticking": 0.4, "decay": 0.9}},
        "bit", "expected `sticking` not below `sliding` (0.5), found 0.4",
    ),
    ({"bit_side_force": {"force": 10.0}}, "bit", "a force cannot move such a bit"),
    ({"bit_side_force": {"moment": 10.0}}, "bit", "a moment cannot move such a bit"),
    ({"bit_stabiliser": {"gauge": 0.3, "stiffness": 1e6}}, "bit", "found bit_end guided with a bit_stabiliser"),
    ({"bit_mass": {"mass": -1.0}}, "bit", "at least 0 kg"),
]  # fmt: skip


@pytest.mark.parametrize(("effects", "at", "words"), REFUSED)
def test_what_cannot_be_is_refused(effects, at, words):
    with pytest.raises(ValidationError) as caught:
        steel(effects, at=at)
    assert words in str(caught.value)


def test_a_stabiliser_fits_the_hole_and_goes_with_its_bit_end():
    with pytest.raises(ValidationError, match="found bit_end stabilised without a bit_stabiliser"):
        rod_scene(effects={}, bit_end="stabilised")
    with pytest.raises(ValidationError, match="at most the diameter of the hole"):
        rod_scene(effects={"bit_stabiliser": {"gauge": 11.0, "stiffness": 1e6}}, bit_end="stabilised")


@pytest.mark.parametrize("key", ["rock_floor", "bit_cutting", "bit_torque_tanh", "bit_side_force"])
def test_a_law_along_or_about_the_axis_needs_stretch_and_torsion(key):
    data = steel({}).model_dump(exclude_none=True)
    data["effects"] = {key: {"stiffness": 1e8} if key == "rock_floor" else {}}
    with pytest.raises(ValidationError, match=f"{key} needs stretch"):
        type(steel({})).model_validate(data)


def bounced(weight: float, speed: float, height: float = 1e-4, damping: float = 5e4) -> tuple[np.ndarray, np.ndarray]:
    """Weight on bit [N] and torque of the rock [N m] over ten lobes, once three seconds have passed."""
    rock = {"stiffness": 1e8, "damping": damping, "lobe_height": height}
    twin = Twin(steel({"rock_floor": rock}, at="top", weight_on_bit=weight, step=2.5e-4))
    twin.unknowns[1][:, SPIN] = speed
    twin.advance(Command(weight, speed), 3.0)
    rows = [twin.advance(Command(weight, speed), 1e-3).rig for _ in range(round(2e4 * np.pi / 3.0 / speed))]
    return np.array([row.bit_force for row in rows]), np.array([row.bit_torque for row in rows])


@pytest.mark.parametrize("speed", [20.0, 70.0])
def test_three_lobes_shake_the_bit_thrice_a_revolution(speed):
    """A free rod on a spring whose foot moves by a cos(3 psi): F = k a D / (k + D), D = -E A w / c tan(w L / c).

    With k = K + i w C and E (1 + i w t). The mean power of the rock's torque is what spring and rod take.
    """
    force, torque = bounced(1e5, speed)
    wave, area = 3.0 * speed, np.pi / 4.0 * (0.2**2 - 0.1**2)
    young = 210e9 * (1.0 + 2e-3j * wave)
    number = wave / np.sqrt(young / 7850.0)
    rod, spring = -young * area * number * np.tan(number * 10.0), 1e8 + 5e4j * wave
    exact = spring * 1e-4 * rod / (spring + rod)
    assert np.sqrt(2.0) * np.std(force) == pytest.approx(abs(exact), rel=0.02)
    assert force.mean() == pytest.approx(1e5, rel=1e-3)
    power = 0.5 * (exact * np.conj(1e-4j * wave)).real
    assert -torque.mean() * speed == pytest.approx(power, rel=0.03, abs=3e-4 * np.ptp(torque) * speed)


def test_a_bit_lifts_off_its_lobes_where_their_force_is_above_the_weight():
    """At 50 rad/s lobes of 0.1 mm shake with 7 kN: under 10 kN the bit stays on the rock, under 5 kN it does not."""
    for weight, leaves in ((10e3, False), (5e3, True)):
        force, torque = bounced(weight, 50.0)
        assert bool(force.min() <= 0.0) == leaves
        assert np.all(torque[force <= 0.0] == 0.0)


@pytest.mark.long
def test_a_bit_that_is_lifted_off_a_rock_floor_has_no_torque():
    """The law of torque takes the force of the rock, in the equations too, though it is listed before the rock."""
    effects = {"bit_torque_tanh": {}, "bit_mass": {"inertia": 1.0}, "rock_floor": {"stiffness": 1e8, "damping": 1e5}}
    twin = Twin(steel(effects, at="top", weight_on_bit=1e5))
    turning = [twin.advance(Command(1e5, SPEED), 0.1).rig.bit_torque for _ in range(10)]
    assert turning[-1] < 0.0
    for _ in range(10):
        twin.advance(Command(-1e5, SPEED), 0.05)
    twin.dynamics.command[0] = 1e5
    falling = twin.advance(Command(1e5, SPEED), 0.01).rig
    assert falling.bit_force == falling.bit_torque == 0.0
    assert abs(falling.top_drive_torque) < 0.01 * abs(turning[-1])
