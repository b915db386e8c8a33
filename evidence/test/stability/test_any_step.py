# SPDX-License-Identifier: Apache-2.0
"""No constant and no step makes the scheme blow up (docs/stability.md): a thousand times an explicit scheme's bound.

One kernel, that of the energy audit, serves all: what a case does not call for has nothing to do.
"""

from typing import Any

import numpy as np
import pytest

from drill_twin.dynamics.twin.frame import Frame
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.scene.set_points import Command
from drill_twin_evidence.stability import draw, explicit_limit, stability_map
from drill_twin_evidence.verify.scenes import EI, LENGTH, LINE_MASS, WALLED, rod_scene

STEP = 0.05
STILL = Command(0.0, 0.0)


def twin_of(effects: dict[str, Any], *, elements: int = 40, step: float = STEP, **options: Any) -> Twin:
    made = rod_scene(effects={**WALLED, "gravity": {"magnitude": 0.0}, **effects}, elements=elements, step=step,
                     form="lateral", frame_rate=20.0, **options)  # fmt: skip
    return Twin(made.model_copy(update={"numerics": made.numerics.model_copy(update={"audit": "energy"})}))


def shaken(twin: Twin, size: float = 0.01) -> Twin:
    """Every node with a velocity of its own: all waves that the mesh has, the fastest too."""
    _, v = twin.unknowns
    random = np.random.default_rng(1)
    v[1:-1, 0:2] = size * random.normal(size=v[1:-1, 0:2].shape)
    v[1:-1, 3:5] = size / twin.rod.length[0] * random.normal(size=v[1:-1, 3:5].shape)
    return twin


def energy(frame: Frame) -> float:
    return frame.energy.stored["kinetic"] + frame.energy.stored["bending"]


def test_the_explicit_bound_is_that_of_the_text_book():
    """That of a heavy wall is 2 sqrt(m / K) and of a drag alone 2 m / c, but that wall and drag are sampled at two
    Gauss points of an element, which weigh up to twice what its consistent mass does there.

    That of bending is 2 / w of the mesh's fastest wave. With cubic elements w^2 m h^4 / EI is 2520 where all nodes of
    an endless mesh turn alike (12 over 2/420) and 8400 of a single free element; a mesh with free ends is between.
    """
    rod = twin_of({}, elements=50).rod
    h = LENGTH / 50
    slow, fast = (np.sqrt(EI / LINE_MASS * square) / h**2 for square in (2520.0, 8400.0))
    assert 2.0 / fast < explicit_limit(rod) < 2.0 / slow
    assert 0.7 < explicit_limit(rod, wall=1e12) / (2.0 * np.sqrt(LINE_MASS / 1e12)) < 1.0
    assert 0.5 < explicit_limit(rod, drag=1e6) / (2.0 * LINE_MASS / 1e6) < 1.0


@pytest.mark.parametrize(("effects", "bound", "elements"), [
    ({}, {}, 200),
    ({"internal_damping": {"bending_time": 0.1}}, {"damping_time": 0.1}, 40),
    ({"drag": {"linear": 1e4}}, {"drag": 1e4}, 200),
], ids=["bending", "damping", "drag"])  # fmt: skip
def test_linear_forces_are_stable_far_beyond_an_explicit_bound(effects, bound, elements):
    twin = shaken(twin_of(effects, elements=elements))
    assert 1000.0 * explicit_limit(twin.rod, **bound) < STEP
    frames = [twin.advance(STILL, STEP) for _ in range(100)]
    seen = np.array([energy(frame) for frame in frames])
    assert (np.diff(seen) <= 1e-9 * seen[0]).all()
    assert all(frame.stats.cut_steps == 0 and frame.intervention is None for frame in frames)
    if not bound:
        assert seen == pytest.approx(seen[0], rel=1e-9)  # nothing is damped that should not be


def test_a_linear_wall_is_stable_far_beyond_an_explicit_bound():
    """The rod falls on the low side of a horizontal hole whose wall is a thousand times too stiff, and lies there."""
    stiffness = 1e9
    effects = {"gravity": {"magnitude": 9.81}, "wall": {"linear_stiffness": stiffness, "restitution": 0.05},
               "drag": {"linear": 0.5}}  # fmt: skip
    twin = twin_of(effects, radius=0.03, inclination=np.pi / 2, bit_end="free")
    assert 1000.0 * explicit_limit(twin.rod, wall=stiffness) < STEP
    frames = [twin.advance(STILL, STEP) for _ in range(200)]
    fall = LINE_MASS * LENGTH * 9.81 * 0.03
    assert max(frame.energy.stored["kinetic"] for frame in frames) < 2.0 * fall
    assert frames[-1].energy.stored["kinetic"] < 5e-3 * fall
    lying = twin.rod.arc < 2.0
    assert frames[-1].positions[lying, 0] == pytest.approx(0.03 - 0.00825, abs=1e-4)


WILD = [
    {"wall_friction": {"coefficient": mu, "accuracy": xi}} for mu in (0.05, 5.0) for xi in (1.0, 1e6, 1e12)
] + [{"internal_damping": {"bending_time": time}} for time in (1e-6, 1e-3, 1.0, 10.0)]  # fmt: skip


@pytest.mark.parametrize("effects", WILD, ids=str)
def test_no_friction_and_no_damping_can_blow_up(effects):
    """Kicked into the wall of a narrow hole and left to itself: what was put in is an upper bound, but for what
    Newton's method leaves undone at impacts; friction and damping only take."""
    kick = {"lateral_kick": {"velocity": 0.5, "shape": "hump"}, "wall": {"stiffness": 1e7}}
    twin = twin_of({**kick, **effects}, elements=16, step=5e-3, radius=0.03)
    start = 0.5 * float(np.einsum("eic,eij,ejc->", *_elements(twin)))
    frames = [twin.advance(STILL, STEP) for _ in range(40)]
    assert max(energy(frame) + frame.energy.stored["wall"] for frame in frames) < 1.3 * start
    heat = np.array([[frame.energy.dissipated[key] for key in ("wall_friction", "internal_damping")]
                     for frame in frames])  # fmt: skip
    assert (np.diff(heat, axis=0) >= -1e-12 * start).all()


def test_whatever_the_damping_time():
    """Beyond what a scene may say, a thousand seconds: the string is then a dead weight."""
    twin = twin_of({"internal_damping": {"bending_time": 10.0}, "lateral_kick": {"velocity": 0.5, "shape": "hump"}})
    damping = twin.dynamics.parameters.internal_damping._replace(bending_time=1e3)
    twin.dynamics.set_parameters(twin.dynamics.parameters._replace(internal_damping=damping))
    seen = [energy(twin.advance(STILL, STEP)) for _ in range(40)]
    assert seen[-1] <= seen[0]
    assert np.isfinite(seen).all()


def _elements(twin: Twin):
    _, v = twin.unknowns
    rows = np.stack([v[:-1, 0:2], v[:-1, 3:5], v[1:, 0:2], v[1:, 3:5]], 1)
    return rows, twin.rod.mass, rows


def test_the_map_is_measured_and_drawn(tmp_path):
    """Two by two cells of each panel: all are followed, and a finer step keeps better track of the energy."""
    maps = {
        "wall": stability_map("wall", steps=(1e-4, 5e-3), values=(1e4, 1e7)),
        "damping_time": stability_map("damping_time", steps=(1e-4, 5e-3), values=(1e-5, 1e-1)),
    }
    for rows in maps.values():
        assert all(cell.followed and cell.iterations >= 1.0 for row in rows for cell in row)
        assert [row[0].limit > row[1].step for row in rows] == [False, False]
        assert all(row[0].energy < 0.05 for row in rows)
    draw(maps, tmp_path / "stability.png")
    assert (tmp_path / "stability.png").stat().st_size > 10_000
