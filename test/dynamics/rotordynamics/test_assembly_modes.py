# SPDX-License-Identifier: Apache-2.0
"""Lateral modes of an assembly on two meshes, each with the one that is nearest to it."""

import cmath
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from drill_twin.api import rotordynamics
from drill_twin.core.errors import RunError
from drill_twin.dynamics.rotordynamics import assembly_modes, forced_response
from drill_twin.dynamics.rotordynamics.assembly import Assembly, assembly_of
from drill_twin.dynamics.rotordynamics.assembly_modes import modes_along
from drill_twin.dynamics.rotordynamics.equations import EquationsOfMotion
from drill_twin.dynamics.rotordynamics.modes import MIXED, Mode, classed, coupled_modes
from drill_twin.dynamics.rotordynamics.turning_frame import HoleFrame
from drill_twin.scene import load_scene
from drill_twin.scene.set_points.command import Command


def modes_at(*eigenvalues: complex) -> list[tuple[Mode, Any]]:
    return [(Mode("lateral", value, np.ones(3, complex)), None) for value in eigenvalues]


def paired(monkeypatch: Any, coarse: Any, moved: Any, fine: Any) -> list[Mode]:
    """The modes that are kept, of those of the coarse mesh, of the moved cut, and of the fine mesh."""

    nothing = {name: lambda *_: None for name in ("pencil", "on")}
    parts = iter([SimpleNamespace(modes=modes, **nothing) for modes in (coarse, moved, fine)])
    monkeypatch.setattr(assembly_modes, "assembly_of", lambda *_, **__: next(parts))
    monkeypatch.setattr(assembly_modes, "_refined", lambda *_: None)
    monkeypatch.setattr(assembly_modes, "lateral_modes", lambda part, *_: part.modes)
    given: Any = None
    return assembly_modes.assembly_modes(given, Command(0.0, 1.0), 10.0, given)[2]


def test_pairs_whose_difference_does_not_add_up_are_pairs(monkeypatch):
    """In floats m + (o - m) is not always o: of 500 pairs some 80."""
    random = np.random.default_rng(1)
    lost = 0
    for _ in range(500):
        frequency = random.uniform(5.0, 20.0)
        coarse = complex(-random.uniform(0.02, 1.0), frequency)
        fine = complex(-random.uniform(0.02, 1.0), frequency * (1.0 + 1e-3 * random.normal()))
        lost += coarse + (fine - coarse) != fine
        (kept,) = paired(monkeypatch, modes_at(coarse), modes_at(coarse), modes_at(fine))
        assert (kept.eigenvalue, kept.change, kept.number) == (fine, fine - coarse, 1)
    assert lost > 20


def test_a_mode_without_a_partner_is_left_out(monkeypatch):
    coarse = modes_at(-0.1 + 5.0j, -0.1 + 9.0j)
    assert paired(monkeypatch, coarse, [], coarse) == []
    assert paired(monkeypatch, coarse, coarse, []) == []
    moved = modes_at(-0.1 + 5.0j, -0.1 + 8.0j)
    kept = paired(monkeypatch, coarse, moved, coarse)
    assert [mode.eigenvalue for mode in kept] == [-0.1 + 5.0j]


def test_each_mode_of_the_fine_mesh_is_taken_once(monkeypatch):
    """Two of the coarse mesh may have the same neighbour, and two of the fine mesh the same eigenvalue."""
    near = modes_at(-0.1 + 5.0j, -0.1 + 5.001j)
    kept = paired(monkeypatch, near, near, modes_at(-0.1 + 5.0j))
    assert [mode.number for mode in kept] == [1]
    assert not cmath.isnan(kept[0].change)


def test_a_string_that_does_not_turn_is_told_what_to_give():
    given: Any = None
    with pytest.raises(RunError, match=r"found 0 rad/s: .* does not turn; give one, such as --rpm 120$"):
        assembly_modes.table_of(load_scene("wells/vertical_3000"), Command(1e5, 0.0), 10.0, given, 6)


def test_an_axial_mode_that_takes_pipe_on_the_low_side_along_stays_axial():
    """A fifth across the hole: `modes` of a well of 9,000 ft lost its second axial mode, and counted on."""
    equations = EquationsOfMotion(load_scene("pa6_bench", overrides={"numerics.elements": "8"}))
    rows = np.zeros((9, 7))
    rows[:, 0], rows[:, 2] = 0.5, 1.0
    mode = rows[:, equations.columns][equations.free]
    frame, part = HoleFrame.of(equations), np.arange(mode.size)
    kinds = [
        classed(equations, frame, part, np.eye(mode.size), 1j, mode, mixed=mixed).kind
        for mixed in (MIXED, assembly_modes.MAJORITY)
    ]
    assert kinds == ["lateral", "axial"]


@pytest.mark.parametrize("well", ["extended_reach", pytest.param("s_shaped", marks=pytest.mark.long)])
def test_torsional_and_axial_modes_are_those_among_all_modes_near_zero(well, monkeypatch):
    """The first axial mode of s_shaped is found from 12 % away."""
    given = []
    monkeypatch.setattr(
        assembly_modes, "modes_along", lambda *arguments: given.append(arguments[:2]) or modes_along(*arguments)
    )
    rotordynamics.modes(rotordynamics.steady_scene(f"wells/{well}", None, ()), count=1)
    ((equations, pencil),) = given
    every = coupled_modes(equations, np.arange(equations.unknowns), pencil, None)
    reach = max(abs(mode.eigenvalue) for mode in every)
    found = modes_along(equations, pencil, 8)
    for kind in ("torsional", "axial"):
        own, among = (
            sorted((mode.eigenvalue for mode in modes if mode.kind == kind), key=abs) for modes in (found, every)
        )
        assert len(own) >= 8
        assert [value for value in own if abs(value) < reach] == pytest.approx(among, rel=1e-6)


@pytest.fixture(scope="module")
def low_side():
    """Assembly of a well, its modes and its forced response up to twice the rotation."""
    scene = rotordynamics.steady_scene("wells/extended_reach", None, ())
    table = rotordynamics.modes(scene, count=1)
    return table, rotordynamics.forced_response(scene, table)


def test_a_response_is_that_of_the_equations_at_each_speed(low_side, monkeypatch):
    """Entries interpolated over the speed give what entries computed at each speed give."""
    table, found = low_side
    monkeypatch.setattr(forced_response, "INTERPOLATED", 0.0)
    few = found.speeds[::40]
    calls: list[float] = []
    entries = Assembly.entries
    monkeypatch.setattr(Assembly, "entries", lambda part, *at: calls.append(at[0]) or entries(part, *at))
    each = np.concatenate([*forced_response._responses(table.assembly, few, found.speeds[-1])])
    assert len(calls) == forced_response.POINTS + 2 + few.size
    monkeypatch.undo()
    smooth = np.concatenate([*forced_response._responses(table.assembly, few, found.speeds[-1])])
    assert np.abs(smooth - each).max() < 1e-6 * np.abs(each).max()


def test_a_cubic_motion_is_the_same_on_another_mesh(low_side):
    """The shape functions are cubic; the bit's row is in a frame of its own, and nothing moves above the cut."""
    scene, command = low_side[0].scene, low_side[0].balance.command
    parts = [
        assembly_of(scene, command, 20.0, lambda equations, command, *_: equations.on_axis(command)[0], finer=finer)
        for finer in (1, 2)
    ]
    motions = []
    for part in parts:
        arc, cut = part.equations.model.rod.arc, part.extent.cut
        rows = np.zeros((arc.size, 7), complex)
        rows[:, 0], rows[:, 3] = 1j * arc * (cut - arc) ** 2, 1j * (cut - arc) * (cut - 3.0 * arc)
        rows[arc > cut] = 0.0
        motions.append(part.frame.fixed(rows, back=True)[:, part.equations.columns][part.rows.free])
    moved = parts[0].on(parts[1], motions[0])
    assert moved.size > motions[0].size
    assert np.abs(moved - motions[1]).max() < 1e-9 * np.abs(moved).max()


def test_a_figure_has_one_sign_of_each_mode(low_side):
    """The largest motion is to the low side or sideways to the left, however the iteration ended."""
    table, _ = low_side
    for mode in table.of("lateral"):
        peak = mode.shape[np.abs(mode.shape).argmax()]
        assert peak.real + peak.imag > 0.0


@pytest.mark.long
def test_two_modes_that_the_mesh_shifts_past_each_other_are_both_kept():
    """The collars of vertical_3000 and pipe above them: 53.6 and 53.3 rpm on one mesh, 53.1 and 53.5 on the finer."""
    modes = rotordynamics.modes("wells/vertical_3000").of("lateral")
    for speed, of_collars in ((53.07, True), (53.49, False), (116.5, True), (117.7, False)):
        (own,) = (mode for mode in modes if abs(mode.frequency * 60.0 - speed) < 0.1)
        assert own.of_collars is of_collars
        assert abs(own.change) < 0.02 * abs(own.eigenvalue)
