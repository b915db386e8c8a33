"""Modes, Campbell diagram and map of growth rates of the bench."""

from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import scipy.sparse.linalg

import drill_twin as dt
from drill_twin.api import rotordynamics
from drill_twin.core.errors import RunError
from drill_twin.core.table import Table
from drill_twin.core.units.system import SYSTEMS
from drill_twin.dynamics.discretisation.joint import collars_of
from drill_twin.dynamics.rotordynamics import modes as modes_module
from drill_twin.dynamics.rotordynamics.assembly import Extent
from drill_twin.dynamics.rotordynamics.assembly_modes import critical_ranges, in_trough
from drill_twin.dynamics.rotordynamics.campbell import campbell, critical_speeds, growth_map, mac
from drill_twin.dynamics.rotordynamics.eigenvalues import (
    MOST_UNKNOWNS,
    Pencil,
    eigenvalues,
    eigenvalues_only,
    modes_near,
    threads_of_blas,
)
from drill_twin.dynamics.rotordynamics.equations import EquationsOfMotion, meshed
from drill_twin.dynamics.rotordynamics.modes import compared, modes
from drill_twin.physics.effects.bit_torque_stribeck import BitTorqueStribeck
from drill_twin.scene import load_scene
from drill_twin.scene.set_points.command import Command
from drill_twin.studies.answers import _resonances, shown_modes

CONFIG = Path(__file__).resolve().parents[3] / "config"


def test_a_basis_of_few_modes_gives_the_growth_of_all(equations):
    weights, speeds = np.array([2.0, 20.0]), np.array([4.0, 20.0])
    few = growth_map(equations, weights, speeds).lateral
    for i, weight in enumerate(weights):
        for k, speed in enumerate(speeds):
            full = modes(equations, Command(weight, speed), count=100).fastest("lateral").growth
            assert few[i, k] == pytest.approx(full, abs=2e-3)


def test_campbell_follows_each_mode_and_finds_its_critical_speed(equations):
    speeds = np.linspace(0.5, 20.0, 20)
    diagram = campbell(equations, 5.0, speeds)
    steps = np.abs(np.diff(diagram.eigenvalues, axis=0)).max(axis=0)
    assert (steps[:5] < 2.0).all()  # no jump from one mode to another
    mode, speed = diagram.critical[0]
    at = modes(equations, Command(5.0, speed), count=20).of("lateral")
    assert min(abs(one.eigenvalue.imag - speed) for one in at) < 0.01 * speed
    assert diagram.eigenvalues[0, mode].imag > 0.0


def test_mac_is_one_for_a_shape_and_its_multiple():
    shape = np.array([[1.0 + 1.0j], [2.0], [0.5j]])
    assert mac(shape, 3.0j * shape)[0, 0] == pytest.approx(1.0)
    assert mac(shape, np.array([[2.0], [-1.0 + 1.0j], [0.0]]))[0, 0] == pytest.approx(0.0, abs=1e-12)


def test_growth_map_has_the_buckling_load_at_low_speed(equations):
    found = growth_map(equations, np.linspace(6.0, 12.0, 7), np.array([0.05]))
    onset = found.onset(found.lateral)[0]
    stiff = []
    for weight in (8.0, 9.5):
        stiffness = modes(equations, Command(weight, 0.05)).balance.system.matrices[2]
        stiff.append(np.linalg.eigvalsh(0.5 * (stiffness + stiffness.T))[0])
    assert stiff[0] > 0.0 > stiff[1]
    assert 8.0 < onset < 9.5


def test_an_inclined_hole_has_no_string_on_the_axis(bench):
    inclined = bench.model_copy(update={"hole": bench.hole.model_copy(update={"inclination": 0.5})})
    equations = EquationsOfMotion(inclined)
    with pytest.raises(RunError, match="expected a straight vertical hole"):
        campbell(equations, 5.0, np.array([1.0, 2.0]))


@pytest.fixture
def damped():
    """Pencil of 40 unknowns without symmetry."""
    random = np.random.default_rng(3)
    mass, damping, stiffness = random.normal(size=(3, 40, 40)) * np.array([0.02, 0.05, 0.1])[:, None, None]
    return Pencil(mass + np.eye(40), damping, stiffness + np.diag(np.linspace(1.0, 400.0, 40)))


@pytest.mark.parametrize("kind", [float, complex])
@pytest.mark.parametrize("shift", [0.01, -0.1 + 7.0j])
def test_modes_near_a_point_are_the_nearest_of_all(damped, kind, shift):
    """Their shapes too: M s^2 + C s + K takes each to zero."""
    pencil = Pencil(damped.mass.astype(kind), damped.damping.astype(kind), damped.stiffness.astype(kind))
    every, _ = eigenvalues(pencil)
    values, shapes = modes_near(pencil, shift, 6)
    away = np.sort(np.abs(every - shift))
    assert np.sort(np.abs(values - shift)) == pytest.approx(away[:6], rel=1e-9)
    left = sum(matrix @ shapes * values**power for matrix, power in zip(pencil, (2, 1, 0), strict=True))
    assert np.linalg.norm(left, axis=0) == pytest.approx(0.0, abs=1e-8 * np.linalg.norm(shapes))


def test_eigenvalues_are_sought_with_one_thread_of_blas(damped, monkeypatch):
    """Two threads on a busy machine took nine times the processor time; the user's number is set again."""
    before, inside = threads_of_blas(2), []
    if not before:
        pytest.skip("scipy has no OpenBLAS here")
    search = scipy.sparse.linalg.eigs
    monkeypatch.setattr(
        scipy.sparse.linalg,
        "eigs",
        lambda *given, **named: inside.append(threads_of_blas(1)) or search(*given, **named),
    )
    modes_near(damped, count=6)
    assert (inside, threads_of_blas(before)) == ([1], 2)


@pytest.mark.slow
def test_few_modes_of_a_string_on_the_wall_are_those_of_the_full_matrices():
    """Where friction couples the wall's stiffness with the soft motion along it, no undamped modes are a basis."""
    scene = load_scene("pa6_bench", overrides={"hole.inclination": "0.5 rad", "numerics.elements": "45", "wob": "5 N"})
    found = rotordynamics.modes(scene, count=10)
    system = found.balance.system
    assert system.matrices[2].shape[0] > MOST_UNKNOWNS
    full = eigenvalues_only(Pencil(*system.matrices))
    for mode in found.modes:
        assert np.abs(full - mode.eigenvalue).min() < 1e-6 * abs(mode.eigenvalue) + 1e-6
    swinging = full[np.abs(full.imag) > 1e-6 * np.abs(full)]
    assert abs(found.modes[0].eigenvalue) == pytest.approx(np.abs(swinging).min(), rel=1e-6)


def test_an_assembly_that_does_not_turn_is_refused():
    """Friction holds it: all motions creep, and the iteration found none of them in minutes."""
    with pytest.raises(RunError, match="found 0 rad/s: friction holds a string that does not turn"):
        rotordynamics.modes(CONFIG / "wells" / "s_shaped.yaml", {"rpm": "0"})


LONG = [pytest.param(well, marks=pytest.mark.long) for well in ("s_shaped", "vertical_3000")]


@pytest.mark.slow
@pytest.mark.parametrize("well", ["extended_reach", *LONG])
def test_a_well_has_modes_of_its_assembly_and_a_forced_response(well):
    """Critical speeds do not move with the cut, and the response to unbalance is largest at one of them."""
    scene = rotordynamics.steady_scene(CONFIG / "wells" / f"{well}.yaml", None, ())
    table = rotordynamics.modes(scene)
    lateral = table.of("lateral")
    assert not table.on_axis
    assert table.assembly.leans == (well == "vertical_3000")
    assert all(mode.growth < 0.0 and abs(mode.cut_change) < 0.01 * abs(mode.eigenvalue) for mode in lateral)
    at = table.assembly.equations.model.rod.arc[[abs(mode.shape).argmax() for mode in lateral]]
    assert all(place > table.assembly.collars for mode, place in zip(lateral, at, strict=True) if mode.share < 0.1)
    if well == "s_shaped":  # a string of 3,000 m winds up and back in some six seconds
        assert table.of("torsional")[0].frequency == pytest.approx(0.1733, rel=2e-3)
        assert [in_trough(table, mode) for mode in lateral] == [mode.frequency < 1.0 for mode in lateral]
        assert critical_ranges(table)[0] == [pytest.approx(11.96, rel=0.01)]
        assert len(critical_ranges(table, trough=True)[0]) == 2
        tables = [said for said in shown_modes(table, None, scene) if isinstance(said, Table)]
        assert ["sideways" in str([*map(list, said.rows)]) for said in tables] == [False, True, False]
        assert ["torsional 1", "0.1733", "10.4"] in [[*row][:3] for row in tables[2].rows]  # Hz, 60 f
    told = " ".join(str(said) for said in shown_modes(table, None, scene))
    assert "mud that turns with the string" in told
    assert "added_mass.confined" not in told, "the gap is in the model"
    assert min(mode.damping_ratio for mode in lateral) > 1e-3, "mud brakes every mode; drag without it gave 4.5e-6"
    response = rotordynamics.forced_response(scene, table)
    peak = response.speeds[response.amplitude[:, 0, -1].argmax()]
    assert min(abs(mode.eigenvalue.imag - peak) for mode in lateral) < 0.02 * peak


def test_critical_speeds_are_those_of_modes_of_the_collars(equations):
    """Heavy-weight that swings in its trough has modes near the rotation, too."""
    table = modes(equations, Command(5.0, 12.57))
    nearest = table.nearest_critical()
    pipe = [mode._replace(share=0.2) if abs(mode.eigenvalue.imag) == nearest else mode for mode in table.modes]
    assert abs(table._replace(modes=tuple(pipe)).nearest_critical() - 12.57) > abs(nearest - 12.57)
    well = load_scene(CONFIG / "wells" / "s_shaped.yaml")
    assert collars_of(well) == 112.5
    assert Extent.of(well).assembly == 262.5


@pytest.mark.parametrize(
    ("changes", "orders", "words"),
    [
        ({}, ("1 a turn", "3 a turn"), "3: cones of a roller cone bit; blades: 1, over their number"),
        ({"bit_torque_stribeck": {"bit": "pdc", "radius": "70 mm"}}, ("1 a turn",), "1: unbalance, bend; blades: 1"),
        ({"bit_torque_stribeck": {"bit": "roller_cone", "radius": "70 mm"}}, ("1 a turn", "3 a turn"), "cone bit); *"),
    ],
)
def test_resonances_are_of_the_excitations_of_the_bit(changes, orders, words):
    """A PDC bit has no cones: three excitations a turn were printed of each bit."""
    well = load_scene(CONFIG / "wells" / "s_shaped.yaml")
    well = well.model_copy(update={"effects": well.effects.model_copy(update={
        "bit_torque_stribeck": None,
        **{key: BitTorqueStribeck.model_validate(block) for key, block in changes.items()},
    })})  # fmt: skip
    mode = SimpleNamespace(kind="torsional", number=1, frequency=0.5, eigenvalue=3.0j)
    found = _resonances([mode], well, Command(5.0, 12.57))
    assert tuple(column.title for column in found.columns)[2:] == orders
    assert words in found.title


def test_resonances_have_lobes_of_the_rock_and_blades_of_the_bit():
    effects = SimpleNamespace(
        bit_regenerative=SimpleNamespace(blades=5), rock_floor=SimpleNamespace(lobes=4.0, lobe_height=1e-3)
    )
    scene = SimpleNamespace(effects=effects, unit_system=SYSTEMS["si"])
    mode = SimpleNamespace(kind="axial", number=1, frequency=0.5, eigenvalue=3.0j)
    found = _resonances([mode], scene, Command(5.0, 12.57))
    assert "(1: unbalance, bend; 4: lobes of the rock; 5: blades of the bit); *" in found.title


def test_a_mode_without_oscillation_has_no_critical_speed():
    """Its frequency is rounding, which a string that begins to turn passes; a mode of 1.5 rad/s is met on the way."""
    speeds = np.linspace(0.0, 4.0, 5)
    modes_of = np.array([(-1.0 + 3e-26j * (k == 0), -0.1 + 1.5j) for k in range(5)])
    assert critical_speeds(speeds, modes_of) == ((1, 1.5),)


def test_critical_speeds_near_each_other_are_one_range(equations):
    """Collars in their trough swing in one, two, three half-waves at nearly one speed."""
    table = modes(equations, Command(5.0, 12.57))
    shown = [table.of("lateral")[0]._replace(eigenvalue=1j * speed) for speed in (4.9, 13.29, 4.82, 5.15)]
    pipe = shown[0]._replace(eigenvalue=5.3j, share=0.4)
    assert critical_ranges(table._replace(modes=(*shown, pipe))) == [[4.82, 4.9], [5.15], [13.29]]


@pytest.mark.slow
def test_without_wall_friction_is_advised_where_there_is_some(monkeypatch):
    sliding = {"hole.inclination": "0.5 rad", "wob": "60 N", "rpm": 120}
    with pytest.raises(RunError, match=r"at 60 N at 2 rev/s, found none.*; try another, or --without wall_friction$"):
        rotordynamics.modes("pa6_bench", sliding)
    monkeypatch.setattr(modes_module, "NEWTON_STEPS", 0)
    with pytest.raises(RunError, match=r"at 60 N at 2 rev/s, found none.*; try another$"):
        rotordynamics.modes("pa6_bench", {"wob": "60 N", "rpm": 120}, without=("wall_friction",))


def test_the_mode_that_grows_fastest_is_always_in_the_table(equations):
    """At 40 N and 2 rev/s the second and the fourth mode grow fastest; a table of one has the second too."""
    whole, short = (modes(equations, Command(40.0, 12.57), count=count) for count in (100, 1))
    assert [mode.number for mode in whole.of("lateral")][:4] == [1, 2, 3, 4]
    assert [mode.number for mode in short.of("lateral")] == [1, whole.fastest("lateral").number]
    assert short.fastest("lateral").growth == whole.fastest("lateral").growth > 1.0
    assert short.growing["lateral"] == sum(mode.growth > 0.0 for mode in whole.of("lateral"))


def test_motions_that_do_not_oscillate_are_no_modes():
    equations = EquationsOfMotion(load_scene("pa6_bench", overrides={"numerics.elements": "12"}))
    table = modes(equations, Command(40.0, 12.57), count=100)
    assert all(mode.frequency != 0.0 for mode in table.modes)
    assert table.creeping["torsional"] > 900.0
    assert "lateral" not in table.creeping


def test_modes_of_the_diagram_have_the_numbers_of_the_table(equations):
    speed = 12.57
    diagram = campbell(equations, 5.0, np.array([6.0, speed, 20.0]), numbered_at=speed)
    table = modes(equations, Command(5.0, speed), count=6).of("lateral")
    assert [mode.eigenvalue for mode in table] == pytest.approx(list(diagram.eigenvalues[1]))


def test_a_mode_is_compared_with_a_mesh_twice_as_fine(bench):
    """Cubic elements: the error falls to a sixteenth."""
    command = Command(5.0, 12.57)
    by_mesh = [modes(EquationsOfMotion(meshed(bench, n)), command, count=100) for n in (12, 24, 48)]
    first, second = (compared(one, finer).of("lateral")[2] for one, finer in pairwise(by_mesh))
    assert abs(first.change) > 10.0 * abs(second.change) > 0.0
    assert dt.modes(bench, {"wob": 5.0}).modes[2].change != 0.0
