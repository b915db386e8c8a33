# SPDX-License-Identifier: Apache-2.0
"""Discs, supports and gyroscopic moments against closed forms of rotors, in modes, forced response and runs."""

import math
from typing import Any

import numpy as np
import pytest

from drill_twin.api import campbell, modes
from drill_twin.core.errors import SceneError
from drill_twin.dynamics.rotordynamics.equations import EquationsOfMotion
from drill_twin.dynamics.rotordynamics.forced_response import unbalance_response
from drill_twin.dynamics.twin.dynamics import Dynamics
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.scene import Scene
from drill_twin.scene.set_points import Command

YOUNG, DIAMETER, LENGTH = 210e9, 10e-3, 0.6
EI = YOUNG * math.pi / 64.0 * DIAMETER**4
MASS, POLAR, DIAMETRAL = 2.0, 0.02, 0.012
BOTH = ["lateral", pytest.param("spatial", marks=pytest.mark.long)]
SPATIAL = {"stretch": {}, "torsion": {}}
IDLE: dict[str, Any] = {
    "gravity": {"magnitude": 0.0}, "gyroscopic": {}, "internal_damping": {"bending_time": 0.0},
    "lateral_kick": {"velocity": 0.0, "shape": "half_wave"},
}  # fmt: skip
"""Effects of the scene rotor_kit, so that all rotors and that scene share their kernels."""
NO_DISC = {"name": "no_disc", "distance_from_bit": 0.0, "mass": 1e-12}
NO_SUPPORT = {"name": "no_support", "distance_from_bit": 0.0, "damping": 1e-12}
DISC = {"name": "disc", "distance_from_bit": 0.0, "mass": MASS, "polar_inertia": POLAR, "diametral_inertia": DIAMETRAL}


def rotor(
    *,
    discs: list[dict[str, Any]] | None = None,
    supports: list[dict[str, Any]] | None = None,
    ends: tuple[str, str] = ("pinned", "hinged"),
    density: float = 1.0,
    speed: float = 0.0,
    form: str = "lateral",
    effects: dict[str, Any] | None = None,
    **numerics: Any,
) -> Scene:
    """A rotor in a wide hole; the shaft has nearly no mass unless a density is given.

    Without discs, or supports, it has one of next to nothing at its end.
    """
    marks = [{"name": "here", "distance_from_bit": place, "on": "centre"} for place in (0.5 * LENGTH,)]
    return Scene.model_validate(
        {
            "name": "rotor",
            "string": {
                "sections": [
                    {"length": LENGTH, "outer_diameter": DIAMETER, "youngs_modulus": YOUNG, "density": density}
                ],
                "discs": [NO_DISC] if discs is None else discs,
                "supports": [NO_SUPPORT] if supports is None else supports,
                "marks": marks,
                "bit_end": ends[0],
                "top_end": ends[1],
            },
            "hole": {"radius": 1.0},
            "rig": {
                "weight_on_bit": {"shape": "constant", "value": 0.0},
                "rotation": {"shape": "constant", "value": speed},
                "duration": 10.0,
            },
            "effects": {**IDLE, **(SPATIAL if form == "spatial" else {}), **(effects or {})},
            "numerics": {"elements": 8, "step": 1e-3, "frame_rate": 100.0, "tolerance": 1e-9, **numerics},
        }
    )  # fmt: skip


def frequencies(scene: Scene, count: int) -> np.ndarray:
    """The lowest lateral frequencies [rad/s] with their sense, by size."""
    found = sorted((mode.eigenvalue.imag for mode in modes(scene, is_compared=False).of("lateral")), key=abs)
    return np.array(found[:count])


@pytest.mark.parametrize("form", BOTH)
def test_a_point_mass_on_a_hinged_beam_has_its_frequency(form):
    """Rayleigh: k = 3 EI L / (a b)^2 at a distance a, b from the ends."""
    at = 0.35 * LENGTH
    stiffness = 3.0 * EI * LENGTH / (at * (LENGTH - at)) ** 2
    own = rotor(discs=[{"name": "mass", "distance_from_bit": at, "mass": MASS}], form=form)
    assert np.abs(frequencies(own, 2)) == pytest.approx(math.sqrt(stiffness / MASS), rel=1e-4)


@pytest.mark.parametrize("off", [1e-7, 1e-5])
def test_a_disc_next_to_a_joint_of_two_sections_moves_no_frequency(off):
    """Places in inches miss a joint in millimetres by micrometres; an element so short leaves rounding only."""

    def stepped(at: float) -> Scene:
        own = rotor(discs=[{"name": "mass", "distance_from_bit": at, "mass": MASS}], density=7850.0)
        first = own.string.sections[0]
        ends = (first.model_copy(update={"length": share * LENGTH}) for share in (0.4, 0.6))
        string = own.string.model_copy(update={"sections": tuple(ends)})
        return own.model_copy(update={"string": string})

    there, beside = (frequencies(stepped(0.4 * LENGTH + each), 6) for each in (0.0, off))
    assert beside == pytest.approx(there, rel=1e-4)


def test_jeffcotts_rotor_answers_unbalance_through_its_critical_speed():
    """Jeffcott 1919: X = U W^2 / (k - m W^2 + i c W)."""
    stiffness, damping = 48.0 * EI / LENGTH**3, 8.0
    own = rotor(
        discs=[{"name": "disc", "distance_from_bit": 0.5 * LENGTH, "mass": MASS}],
        supports=[{"name": "damper", "distance_from_bit": 0.5 * LENGTH, "damping": damping}],
    )
    critical = math.sqrt(stiffness / MASS)
    speeds = critical * np.array([0.1, 0.6, 0.95, 1.0, 1.05, 2.0, 5.0])
    found = unbalance_response(own, speeds)[:, 0, 0]
    exact = speeds**2 / (stiffness - MASS * speeds**2 + 1j * damping * speeds)
    assert np.abs(found[:, 0] / exact - 1.0).max() < 2e-3  # most beside the peak, by the mass of the shaft
    assert np.abs(found[:, 1] - -1j * found[:, 0]).max() < 1e-9 * np.abs(found).max()  # a circle, forward
    assert np.degrees(np.angle(found[[0, 3, 6], 0])) == pytest.approx([0.0, -90.0, -180.0], abs=3.0)


def overhung(speed: float) -> np.ndarray:
    """Frequencies of a disc on a massless cantilever, forward ones above zero (Genta 2005, section 2.6)."""
    stiffness = EI * np.array([[12.0 / LENGTH**3, 6.0 / LENGTH**2], [6.0 / LENGTH**2, 4.0 / LENGTH]])
    mass, gyro = np.diag([MASS, DIAMETRAL]), np.diag([0.0, POLAR * speed])
    state = np.block([[np.zeros((2, 2)), np.eye(2)], [-np.linalg.solve(mass, stiffness),
                                                      1j * np.linalg.solve(mass, gyro)]])  # fmt: skip
    values = np.linalg.eigvals(state).imag
    return values[np.argsort(np.abs(values))]


@pytest.mark.parametrize("form", BOTH)
def test_an_overhung_disc_splits_its_frequencies_by_the_gyroscopic_moment(form):
    for speed in (0.0, 100.0, 400.0):
        own = rotor(discs=[DISC], ends=("free", "clamped"), speed=speed, form=form)
        found, exact = np.sort(frequencies(own, 4)), np.sort(overhung(speed))
        assert found == pytest.approx(exact, rel=3e-4)
    at_rest, turning = np.sort(overhung(0.0)), np.sort(frequencies(own, 4))
    assert turning[-1] > at_rest[-1]  # stiffer forward
    assert turning[0] > at_rest[0]  # softer backward


@pytest.mark.slow
def test_a_campbell_diagram_crosses_where_the_closed_form_does():
    """A disc with Ip > Id is met forward by its first frequency alone; the diagram has its speed."""
    own = rotor(discs=[DISC], ends=("free", "clamped"), speed=10.0)
    diagram = campbell(own, speeds=np.linspace(5.0, 120.0, 47), count=4)
    speeds = np.linspace(1.0, 119.0, 20001)
    forward = np.array([min(value for value in overhung(speed) if value > 0.0) for speed in speeds])
    exact = speeds[int(np.argmin(np.abs(forward - speeds)))]
    assert [speed for _, speed in diagram.critical] == [pytest.approx(exact, rel=1e-3)]


def test_a_shaft_on_two_springs_bounces_and_pitches():
    density = 7850.0
    mass, spring, apart = density * math.pi / 4.0 * DIAMETER**2 * LENGTH, 50.0, 0.4
    at = [0.5 * (LENGTH - apart), 0.5 * (LENGTH + apart)]
    supports = [{"name": f"s{k}", "distance_from_bit": place, "stiffness": spring} for k, place in enumerate(at)]
    own = rotor(supports=supports, ends=("free", "free"), density=density)
    pitching = mass * (LENGTH**2 / 12.0 + DIAMETER**2 / 16.0)
    exact = [math.sqrt(2.0 * spring / mass), math.sqrt(0.5 * spring * apart**2 / pitching)]
    assert np.unique(np.round(np.abs(frequencies(own, 4)), 6))[[0, -1]] == pytest.approx(sorted(exact), rel=2e-3)


def test_an_elastic_root_lies_between_hinge_and_clamp():
    """Tip mass on a rod whose root turns by the moment over its stiffness: 1 / k = L^3 / (3 EI) + L^2 / k_r."""
    root = 2.0 * EI / LENGTH
    own = rotor(
        discs=[{**DISC, "polar_inertia": 0.0, "diametral_inertia": 0.0}],
        supports=[{"name": "root", "distance_from_bit": LENGTH, "tilt_stiffness": root}],
        ends=("free", "hinged"),
    )
    stiffness = 1.0 / (LENGTH**3 / (3.0 * EI) + LENGTH**2 / root)
    assert np.abs(frequencies(own, 2)) == pytest.approx(math.sqrt(stiffness / MASS), rel=1e-4)


def test_supports_with_two_stiffnesses_split_the_critical_speeds_and_have_no_steady_whirl():
    at = 0.5 * LENGTH
    own = rotor(
        discs=[{"name": "disc", "distance_from_bit": at, "mass": MASS}],
        supports=[{"name": "s", "distance_from_bit": at, "stiffness": 2000.0, "stiffness_y": 5000.0}],
    )
    shaft = 48.0 * EI / LENGTH**3
    exact = [math.sqrt((shaft + more) / MASS) for more in (2000.0, 5000.0)]
    assert np.abs(frequencies(own, 2)) == pytest.approx(exact, rel=1e-4)
    response = np.abs(unbalance_response(own, np.array(exact) * 1.0001)[:, 0, 0])
    assert response[0, 0] > 100.0 * response[0, 1]
    assert response[1, 1] > 100.0 * response[1, 0]


def test_an_oil_film_whirls_a_rotor_at_half_the_rotation():
    """Cross stiffness c W / 2 drives forward whirl: growth (q / w - c) / (2 m) of z'' m + z' c + (k - i q) z = 0."""
    at, damping, cross = 0.5 * LENGTH, 4.0, 2000.0
    film = {"damping": damping, "stiffness_xy": cross, "stiffness_yx": -cross}
    own = rotor(
        discs=[{"name": "disc", "distance_from_bit": at, "mass": MASS}],
        supports=[{"name": "film", "distance_from_bit": at, **film}],
    )
    exact = np.roots([MASS, damping, 48.0 * EI / LENGTH**3 - 1j * cross])
    found = np.array([mode.eigenvalue for mode in modes(own, is_compared=False).of("lateral")[:2]])
    assert np.sort_complex(found) == pytest.approx(np.sort_complex(exact), rel=1e-3)
    assert exact.real.max() > 0.0
    assert exact[np.argmax(exact.real)].imag > 0.0


def swing(scene: Scene, seconds: float) -> np.ndarray:
    """Lateral place and slope of the disc after a time, from a push of the whole rotor in a smooth shape."""
    own = Dynamics(scene)
    u, v = own.unknowns
    share = 1.0 - own.rod.arc / LENGTH
    v[:, 0:2] = share[:, None] ** 2 * [0.02, 0.05]
    v[:, 3:5] = -2.0 / LENGTH * share[:, None] * [0.02, 0.05]
    own.begin(u, v, Command(0.0, scene.rig.rotation.value))
    for _ in range(round(seconds / 0.02)):
        own.advance(np.array([0.0, scene.rig.rotation.value, 0.0]), 0.02)
    return np.concatenate([own.unknowns[0][0, :2], own.unknowns[0][0, 3:5]])


@pytest.mark.parametrize("form", BOTH)
def test_a_whirl_with_gyroscopic_moments_converges_with_the_square_of_the_step(form):
    ends = [
        swing(rotor(discs=[DISC], ends=("free", "clamped"), speed=200.0, form=form, step=step), 0.2)
        for step in (5e-4, 2.5e-4, 6.25e-5)
    ]
    errors = [float(np.linalg.norm(end - ends[-1])) for end in ends[:2]]
    assert errors[0] / errors[1] == pytest.approx((64.0 - 1.0) / (16.0 - 1.0), rel=0.1)  # the last has an error too


@pytest.mark.parametrize("form", BOTH)
def test_a_run_settles_on_the_response_to_unbalance(form):
    discs = [{"name": "disc", "distance_from_bit": 0.5 * LENGTH, "mass": MASS, "unbalance": 2e-4, "angle": 0.5}]
    supports = [{"name": "damper", "distance_from_bit": 0.5 * LENGTH, "damping": 60.0}]
    critical = math.sqrt(48.0 * EI / LENGTH**3 / MASS)
    for share in (0.7, 1.3):
        speed = share * critical
        own = rotor(discs=discs, supports=supports, speed=speed, form=form, step=2.5e-4)
        twin = Twin(own)
        for _ in range(150):
            twin.advance(Command(0.0, speed), 0.01)
        u = twin.dynamics.unknowns[0]
        node = int(np.argmin(np.abs(twin.dynamics.rod.arc - 0.5 * LENGTH)))
        turning = complex(u[node, 0], u[node, 1]) * np.exp(-1j * u[-1, 6])
        expected = 2e-4 * np.exp(0.5j) * unbalance_response(own, np.array([speed]))[0, 0, 0, 0]
        assert abs(turning / expected - 1.0) < 2e-2  # of the step: (W h)^2 / 12 over the distance to the critical speed
    assert np.angle(expected * np.exp(-0.5j)) < -0.5 * math.pi


@pytest.mark.parametrize("form", BOTH)
def test_the_books_of_energy_close_with_a_whirling_disc(form):
    """All work on the string is stored or lost; the work of the rotary inertia is its kinetic energy, to round-off."""
    supports = [{"name": "s", "distance_from_bit": 0.3, "stiffness": 3e3, "damping": 5.0}]
    own = rotor(discs=[{**DISC, "unbalance": 1e-3}], supports=supports, ends=("free", "clamped"), speed=150.0,
                form=form, effects={"gravity": {"magnitude": 9.81}}, audit="energy", density=7850.0)  # fmt: skip
    twin = Twin(own)
    frames = [twin.advance(Command(0.0, 150.0), 0.02).energy for _ in range(50)]
    unknown = max(abs(energy.residual - energy.newton) / energy.scale for energy in frames)
    assert unknown < (1e-10 if form == "lateral" else 1e-5)
    work, v = frames[-1].work, twin.dynamics.unknowns[1]
    tilting = 0.5 * float(twin.dynamics.parameters.gyroscopic.diametral @ (v[:, 3:5] ** 2).sum(axis=1))
    assert -work["gyroscopic"] == pytest.approx(tilting, rel=1e-3)
    spin = v[-1 if form == "lateral" else 0, 6]
    moving = 0.5 * MASS * float(v[0, 0:2] @ v[0, 0:2]) + 0.5 * POLAR * spin**2
    assert -work["discs"] == pytest.approx(moving, rel=1e-2)  # and the work of unbalance and weight
    assert work["supports"] < 0.0


def test_a_disc_hangs_on_the_hook_and_stretches_the_string():
    """Weight of the disc in the tension above it, none below: no force is left that would start an axial wave."""
    disc = {"name": "jar", "distance_from_bit": 0.25, "mass": 50.0}
    own = rotor(discs=[disc], ends=("free", "clamped"), form="spatial", effects={"gravity": {"magnitude": 9.81}},
                density=7850.0)  # fmt: skip
    u, v = Dynamics(own).unknowns
    strain = u[:, 5] - 1.0
    area = math.pi / 4.0 * DIAMETER**2
    shaft = 7850.0 * area * 9.81
    assert strain[-1] * YOUNG * area == pytest.approx(50.0 * 9.81 + shaft * LENGTH, rel=1e-9)
    left = EquationsOfMotion(own).evaluate(Command(0.0, 0.0), u, v, np.zeros_like(v)).residual
    assert np.abs(left).max() < 1e-4 * 50.0 * 9.81


def test_what_cannot_be_is_refused():
    with pytest.raises(ValueError, match="expected a `mass` above 0 kg with an unbalance"):
        rotor(discs=[{"name": "d", "distance_from_bit": 0.1, "mass": 0.0, "unbalance": 1.0}])
    with pytest.raises(ValueError, match="expected a `mass`, or `outer_diameter` and `width`"):
        rotor(discs=[{"name": "d", "distance_from_bit": 0.1}])
    with pytest.raises(ValueError, match="expected a stiffness or a damping above 0"):
        rotor(supports=[{"name": "s", "distance_from_bit": 0.1}])
    with pytest.raises(ValueError, match="expected supports with a stiffness at two places"):
        rotor(ends=("free", "free"), supports=[])
    one_way = [
        {"name": n, "distance_from_bit": at, "stiffness": 1.0, "stiffness_y": 0.0} for n, at in (("a", 0.1), ("b", 0.2))
    ]
    with pytest.raises(ValueError, match="expected supports with a stiffness at two places"):
        rotor(ends=("free", "free"), supports=one_way)
    with pytest.raises(ValueError, match="expected more than the string's"):
        rotor(discs=[{"name": "d", "distance_from_bit": 0.1, "outer_diameter": 0.5 * DIAMETER, "width": 0.1}])
    with pytest.raises(ValueError, match="expected a `weight` that is part of the `mass`"):
        rotor(discs=[{"name": "d", "distance_from_bit": 0.1, "mass": 0.1, "weight": 0.2, "radius": 0.1}])
    with pytest.raises(ValueError, match='expected "d" on the string'):
        rotor(discs=[{"name": "d", "distance_from_bit": 2.0, "mass": 1.0}])
    with pytest.raises(SceneError, match=r"expected a disc in string\.discs"):
        unbalance_response(rotor(discs=[]), np.array([1.0]))


def test_a_disc_of_given_size_has_the_inertia_of_a_ring():
    ring = rotor(discs=[{"name": "d", "distance_from_bit": 0.1, "outer_diameter": 0.15, "width": 0.02}]).string
    mass, polar, diametral, volume = ring.body_of(ring.discs[0])
    assert mass == pytest.approx(7850.0 * math.pi / 4.0 * (0.15**2 - DIAMETER**2) * 0.02)
    assert polar == pytest.approx(mass * (0.15**2 + DIAMETER**2) / 8.0)
    assert diametral == pytest.approx(0.5 * polar + mass * 0.02**2 / 12.0)
    assert volume == pytest.approx(mass / 7850.0)
