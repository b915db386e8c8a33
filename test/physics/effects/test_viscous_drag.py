# SPDX-License-Identifier: Apache-2.0
"""Lateral force of mud in the hole: exact annulus solution by another way, limits, muds that are not Newtonian."""

import numpy as np
import pytest
from numpy.polynomial import chebyshev
from scipy.special import kv, polygamma

from drill_twin.core.errors import SceneError
from drill_twin.dynamics.discretisation.discretise import discretise
from drill_twin.dynamics.discretisation.resolution import mesh
from drill_twin.physics.effects import parameters_of
from drill_twin.physics.effects.mud import in_annulus, lateral_force
from drill_twin.scene import load_scene

RADIUS, NU = 0.1, 1e-5
MUD = "{density: 1200 kg/m^3, viscosity: 20 cP}"


def found(gap, penetration):
    """H in a hole of `gap` radii around a string of `penetration` = r_o sqrt(omega / nu)."""
    rate = NU * (penetration / RADIUS) ** 2
    force = in_annulus(np.array([RADIUS]), np.array([RADIUS * (1.0 + gap)]), np.array([NU]), rate)
    return force.mass[0] - 1j * force.drag[0] / rate


def collocated(gap, penetration, points):
    """H by collocation of the linearised Navier-Stokes equations, force from pressure and shear on the string.

    The stream function f(r) sin(theta) has (L - i S^2) L f = 0, L = d2/dr2 + 1/r d/dr - 1/r2, lengths in radii.
    """
    x = np.cos(np.pi * np.arange(points) / (points - 1))
    value = chebyshev.chebvander(x, points - 1)
    slopes = np.array([chebyshev.chebval(x, chebyshev.chebder(row)) for row in np.eye(points)]).T
    d = slopes @ np.linalg.inv(value) * 2.0 / gap
    r = 1.0 + 0.5 * gap * (1.0 + x)
    bending = d @ d + d / r[:, None] - np.diag(r**-2)
    oscillation = 1j * penetration**2
    equation = bending @ bending - oscillation * bending
    side = np.zeros(points, complex)
    unit = np.eye(points)
    for row, line, held in ((0, unit[0], 0.0), (1, d[0], 0.0), (-1, unit[-1], 1.0), (-2, d[-1], 1.0)):
        equation[row], side[row] = line, held
    f = np.linalg.solve(equation, side)
    vorticity = bending @ f
    return -(oscillation + vorticity[-1] - (d @ vorticity)[-1]) / oscillation


@pytest.mark.parametrize(("gap", "penetration"), [(0.05, 20.0), (0.3, 5.0), (0.5, 60.0), (2.0, 2.0), (5.0, 10.0)])
def test_force_in_an_annulus_is_that_of_the_equations_collocated(gap, penetration):
    assert found(gap, penetration) == pytest.approx(collocated(gap, penetration, 48), rel=2e-6)


def test_a_far_wall_leaves_the_open_fluid():
    """Stokes 1851: H = 1 + 4 K1(z) / (z K0(z)); at high frequency 1 + 4 / z. The wall counts as (r_o / R)^2."""
    for penetration in (1.0, 10.0, 100.0):
        z = np.sqrt(1j) * penetration
        assert found(1e3, penetration) == pytest.approx(1.0 + 4.0 * kv(1, z) / (z * kv(0, z)), rel=5e-6)
    z = np.sqrt(1j) * 1e4
    assert found(1e3, 1e4) == pytest.approx(1.0 + 4.0 / z, rel=5e-6)


@pytest.mark.parametrize("gap", [0.002, 0.05, 0.5, 3.0])
def test_limits_of_fast_and_slow_motion(gap):
    """Fast: potential flow (Fritz 1972). Slow: drag 4 pi mu / (ln k - (k^2 - 1) / (k^2 + 1)), k = R / r_o."""
    k = 1.0 + gap
    potential = (k * k + 1.0) / (k * k - 1.0)
    assert found(gap, 1e5 / gap).real == pytest.approx(potential, rel=1e-4)
    creeping = 4.0 / (np.log(k) - (k * k - 1.0) / (k * k + 1.0))
    drag = [-found(gap, s / gap).imag * (s / gap) ** 2 for s in (0.03, 0.3)]
    assert drag == pytest.approx([creeping] * 2, rel=1e-5)
    assert found(gap, 0.03 / gap).real == pytest.approx(found(gap, 0.3 / gap).real, rel=1e-4)
    rate = 1e-9**2
    assert found(gap, 1e-9).real == pytest.approx(found(gap, 0.3 / gap).real, rel=1e-4), "below SLOWEST the limit holds"
    assert -found(gap, 1e-9).imag * rate == pytest.approx(creeping, rel=1e-5)
    if gap < 0.01:
        assert found(gap, 0.3 / gap).real == pytest.approx(1.2 * potential, rel=1e-3), "parabolic profile: 6/5"


def modelled(mud, *, rpm="120 rpm", **effects):
    """The Gauss points' model of pa6_bench in mud."""
    scene = load_scene("pa6_bench", overrides={"effects.mud": mud, "rpm": rpm} | {
        f"effects.{key}": value for key, value in effects.items()})  # fmt: skip
    return scene, discretise(scene, mesh(scene, 8))


def test_added_mass_and_drag_come_from_one_coefficient_at_the_rotation():
    scene, model = modelled(MUD, added_mass="{confined: true}", viscous_drag="on")
    outer, hole = model.rod.outer_radius[0], scene.hole.radius
    rate = 2.0 * np.pi * 2.0
    exact = in_annulus(np.array([outer]), np.array([hole]), np.array([0.02 / 1200.0]), rate)
    disc = 1200.0 * np.pi * outer**2
    mass = parameters_of("added_mass", scene.effects.added_mass, model).mass
    assert mass == pytest.approx(disc * exact.mass[0], rel=1e-9)  # the rod is solid: no mud inside
    drag = parameters_of("viscous_drag", scene.effects.viscous_drag, model).lateral
    assert drag == pytest.approx(disc * exact.drag[0], rel=1e-9)
    _, given = modelled(MUD.replace("}", ", frequency: 2 Hz}"), rpm="60 rpm")
    assert lateral_force(given).drag == pytest.approx(lateral_force(model).drag, rel=1e-12)
    _, standing = modelled(MUD, rpm="0 rpm")
    assert lateral_force(standing).drag == pytest.approx(lateral_force(modelled(MUD, rpm="60 rpm")[1]).drag)


def test_a_bingham_and_a_power_law_mud_have_their_apparent_viscosity():
    """The coefficient is that of a Newtonian mud of the stress over the rate at the rate on the string."""
    for more in ("yield_point: 5 Pa", "index: 0.6"):
        scene, model = modelled(MUD.replace("}", f", {more}}}"))
        mud, outer, hole = scene.effects.mud, model.rod.outer_radius[:1], np.array([scene.hole.radius])
        rate, low, high = 4.0 * np.pi, 1e-4, 100.0
        for _ in range(100):  # bisection for the viscosity that agrees with its own shear rate
            middle = np.sqrt(low * high)
            force = in_annulus(outer, hole, np.array([middle / mud.density]), rate)
            gamma = force.shear[0] * rate * (hole - outer)[0]
            stress = 0.02 * gamma + 5.0 if "yield" in more else 0.02 * 511.0**0.4 * gamma**0.6
            low, high = (middle, high) if stress / gamma > middle else (low, middle)
        assert lateral_force(model).drag[0] == pytest.approx(force.drag[0], rel=1e-6)
        assert lateral_force(model).drag[0] != pytest.approx(lateral_force(modelled(MUD)[1]).drag[0], rel=1e-2)


@pytest.mark.parametrize(
    ("mud", "told"),
    [
        ("{density: 1200 kg/m^3}", "viscous_drag: expected a viscosity above 0 Pa s in `mud`"),
        ("{density: 1200 kg/m^3, yield_point: 5 Pa}", "expected a `viscosity` above 0 Pa s beside `yield_point`"),
        ("{density: 1200 kg/m^3, viscosity: 20 cP, index: 0}", "at least 0.1"),
    ],
)
def test_mud_that_says_nothing_of_its_drag_is_refused(mud, told):
    with pytest.raises(SceneError, match=told):
        modelled(mud, viscous_drag="on")


COLLARS = {"outer": np.array([0.1016]), "hole": np.array([0.155575]), "rate": 4.0 * np.pi}
"""Collars of 8 in in a hole of 12 1/4 in, 120 rpm."""


def test_drag_of_collars_at_other_frequencies_and_swings():
    """Figures of docs/effects.md."""

    def drag(times=1.0, viscosity=0.02):
        force = in_annulus(COLLARS["outer"], COLLARS["hole"], np.array([viscosity / 1200.0]), COLLARS["rate"] * times)
        return 1200.0 * np.pi * 0.1016**2 * force.drag[0], force.mass[0], force.shear[0]

    assert [drag(times)[0] for times in (1.0, 1.0 / 3.0, 3.0)] == pytest.approx([64.0, 39.0, 109.0], abs=0.5)
    assert [drag(times)[1] / drag()[1] for times in (1.0 / 3.0, 3.0)] == pytest.approx([1.035, 0.98], abs=0.005)
    for swing, told in ((1.0, 69.0), (0.1, 117.0)):
        viscosity = 0.02
        for _ in range(60):
            viscosity = 0.02 + 5.0 / (drag(viscosity=viscosity)[2] * COLLARS["rate"] * swing * (0.155575 - 0.1016))
        assert drag(viscosity=viscosity)[0] == pytest.approx(told, abs=0.5)


def beside_the_wall(outer, hole, offset):
    """Added mass of potential flow around a string off the axis, by images of its doublet in hole and string."""
    strength, place, total = 1.0, 0.0, 1.0
    for _ in range(20000):
        in_hole = hole**2 / (place + offset) - offset
        strength *= (hole * outer / ((place + offset) * in_hole)) ** 2
        place = outer**2 / in_hole
        total += 2.0 * strength
    return total


def test_a_string_on_the_wall_has_more_added_mass_than_the_model_s():
    """Figures of docs/effects.md. Touching: 2 psi_1(1 / b) / b^2 - 1, b = 1 - r_o / R; at a plane wall pi^2 / 3 - 1."""
    outer, hole = COLLARS["outer"][0], COLLARS["hole"][0]
    concentric = in_annulus(COLLARS["outer"], COLLARS["hole"], np.array([1e-12]), COLLARS["rate"]).mass[0]
    assert beside_the_wall(outer, hole, 1e-9) == pytest.approx(concentric, rel=1e-4)
    free = 1.0 - outer / hole
    touching = 2.0 * polygamma(1, 1.0 / free) / free**2 - 1.0
    assert beside_the_wall(outer, hole, (hole - outer) * (1.0 - 1e-7)) == pytest.approx(touching, rel=2e-3)
    assert 2.0 * polygamma(1, 1.0) - 1.0 == pytest.approx(np.pi**2 / 3.0 - 1.0)
    assert beside_the_wall(outer, hole, 0.5 * (hole - outer)) / concentric == pytest.approx(1.09, abs=0.005)
    assert touching / concentric == pytest.approx(2.36, abs=0.01)
