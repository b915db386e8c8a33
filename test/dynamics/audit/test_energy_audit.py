# SPDX-License-Identifier: Apache-2.0
"""The books of energy close: what went in is stored, turned into heat, or in a residual of known order.

One set of effects a form, so that two kernels serve all; what a case does not call for has nothing to do.
"""

from typing import Any

import numpy as np
import pytest
from rod_scenes import WALLED, rod_scene

from drill_twin.dynamics.audit.energy_ledger import FIRST_EFFECT, WORK
from drill_twin.dynamics.solver import kernel_codegen
from drill_twin.dynamics.twin.frame import EnergyBalance
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.physics.effects import Effect
from drill_twin.scene import Scene
from drill_twin.scene.set_points import Command

IDLE: dict[str, dict[str, Any]] = {**WALLED, "lateral_kick": {"velocity": 0.0, "shape": "half_wave"}}
BOTH = ["lateral", pytest.param("spatial", marks=pytest.mark.long)]
KICK = {"lateral_kick": {"velocity": 0.5, "shape": "half_wave"}}
HEAVY = {"gravity": {"magnitude": 9.81}}
DAMPED = {
    "drag": {"linear": 0.02}, "internal_damping": {"bending_time": 5e-3, "stretch_time": 1e-3, "torsion_time": 1e-3},
}  # fmt: skip
LIVELY = {
    **KICK, **HEAVY, **DAMPED, "wall_friction": {"coefficient": 0.3}, "wall": {"stiffness": 1e7, "restitution": 0.5},
}  # fmt: skip


def scene(form: str, effects: dict[str, Any], *, step: float = 2e-3, audit: str = "energy", **options: Any) -> Scene:
    made = rod_scene(effects={**IDLE, **effects}, elements=12, step=step, form=form, frame_rate=50.0, **options)
    return made.model_copy(update={"numerics": made.numerics.model_copy(update={"audit": audit, "tolerance": 1e-8})})


def balances(made: Scene, seconds: float = 2.0, load: float = 0.0, speed: float = 0.0) -> list[EnergyBalance]:
    twin = Twin(made)
    frames = [twin.advance(Command(load, min(k / 20.0, 1.0) * speed), 0.02) for k in range(1, round(seconds * 50) + 1)]
    return [frame.energy for frame in frames]


def worst(found: list[EnergyBalance]) -> float:
    return max(abs(energy.share) for energy in found)


@pytest.mark.parametrize("form", BOTH)
def test_an_undamped_swing_keeps_its_energy(form):
    """Quadratic in the lateral form, hence to round-off; in space to the square of the step (see the next test)."""
    found = balances(scene(form, {**KICK, **HEAVY}, bit_end="free"))
    assert worst(found) < (1e-13 if form == "lateral" else 1e-5)
    assert all(energy.dissipated == dict.fromkeys(energy.dissipated, 0.0) for energy in found)
    # stored energy wanders between its forms, and is there all the time
    kinetic = [energy.stored["kinetic"] for energy in found]
    assert min(kinetic) < 0.5 * max(kinetic)


@pytest.mark.long
def test_what_is_lost_track_of_is_second_order_in_the_step():
    """Large deflection in space, Newton's part left out: its rms falls to a quarter as the step is halved."""
    hard = {"lateral_kick": {"velocity": 2.0, "shape": "half_wave"}, **HEAVY}
    residual = []
    for step in (4e-3, 2e-3, 1e-3):
        found = balances(scene("spatial", hard, bit_end="free", step=step), 1.0)
        residual.append(np.sqrt(np.mean([(energy.residual - energy.newton) ** 2 for energy in found])))
    assert np.log2(np.array(residual[:-1]) / residual[1:]) == pytest.approx(2.0, abs=0.1)


@pytest.mark.parametrize("form", BOTH)
def test_a_damped_string_turns_its_energy_into_heat(form):
    """As above, the forces being linear; after two seconds a good part of the energy is heat."""
    found = balances(scene(form, {**KICK, **HEAVY, **DAMPED}, bit_end="free"))
    assert worst(found) < (1e-13 if form == "lateral" else 1e-5)
    heat = sum(found[-1].dissipated.values())
    assert 0.2 < heat / found[-1].scale < 1.0
    assert found[-1].dissipated["drag"] > 0.0
    assert found[-1].dissipated["internal_damping"] > 0.0


def never_negative(found: list[EnergyBalance]) -> bool:
    heat = np.array([list(energy.dissipated.values()) for energy in found])
    return bool((np.diff(heat, axis=0) >= -1e-9 * found[-1].scale).all())


@pytest.mark.parametrize("form", BOTH)
def test_driven_into_the_wall_with_friction_the_books_still_close(form):
    """Turned and pushed into a narrow hole. The wall gives back its energy exactly, so in the lateral form all that is
    left is what Newton's method left undone, itself below a thousandth; in space also large deflection, to the square
    of the step."""
    given = {"radius": 0.03, "weight_on_bit": 15.0}
    fine, coarse = (balances(scene(form, LIVELY, step=step, **given), load=15.0, speed=12.0) for step in (2.5e-4, 2e-3))
    for found, closed in ((fine, 1e-5), (coarse, 1e-3)):
        left = max(abs(energy.residual - energy.newton) / energy.scale for energy in found)
        assert left < (1e-11 if form == "lateral" else closed)
        assert worst(found) < 1e-3
    assert never_negative(fine)
    assert never_negative(coarse)
    last = fine[-1]
    assert last.dissipated["wall"] > 1e-4
    assert last.dissipated["wall_friction"] > 1e-4
    assert last.work["top_drive"] > 0.0
    assert last.work["weight_on_bit"] > 0.0
    assert set(last.dissipated) == {"bit_friction", "drag", "internal_damping", "wall", "wall_friction"}
    assert last.dissipated["bit_friction"] == 0.0


def test_a_force_that_is_not_accounted_for_is_caught():
    """The drag's entry taken out of the books: the residual is then what it has braked."""
    twin = Twin(scene("lateral", {**KICK, **HEAVY, **DAMPED}, bit_end="free"))
    for _ in range(100):
        frame = twin.advance(Command(0.0, 0.0), 0.02)
    braked = frame.energy.work["drag"]
    audit = twin.energy_audit
    audit._entries[WORK, FIRST_EFFECT + audit._effects.index("drag")] = 0.0
    forged, grown = audit.balance(*twin.unknowns)
    assert braked < -0.02 * forged.scale
    assert forged.residual == pytest.approx(braked, rel=1e-9)
    assert grown == pytest.approx(braked, rel=1e-9)


def test_a_push_from_outside_is_caught():
    """Somebody who changes the velocities between two frames shows in the residual with just what it brought in."""
    twin = Twin(scene("lateral", {**KICK, **HEAVY}, bit_end="free"))
    before = [twin.advance(Command(0.0, 0.0), 0.02) for _ in range(10)][-1].energy
    kinetic = before.stored["kinetic"]
    twin.unknowns[1][:] *= 1.02
    after = twin.advance(Command(0.0, 0.0), 0.02).energy
    assert after.residual - before.residual == pytest.approx((1.02**2 - 1.0) * kinetic, rel=1e-9)


def test_the_books_do_not_touch_the_motion():
    """With and without, the same motion to Newton's tolerance; without, no trace of them."""
    made = [scene("lateral", LIVELY, audit=audit, radius=0.03, weight_on_bit=15.0) for audit in ("energy", "none")]
    with_books, without = (Twin(one) for one in made)
    for _ in range(50):
        one, other = (twin.advance(Command(15.0, 6.0), 0.02) for twin in (with_books, without))
        assert np.allclose(one.positions, other.positions, atol=1e-7)
    assert other.energy is None
    assert "ledger" not in without.dynamics.kernel.Parameters._fields
    assert "audit" not in kernel_codegen.source([Effect("drag")], "lateral")


def test_a_resumed_run_goes_on_with_its_books():
    twin = Twin(scene("lateral", {**KICK, **HEAVY, **DAMPED}, bit_end="free"))
    for _ in range(20):
        twin.advance(Command(0.0, 0.0), 0.02)
    other = Twin(twin.scene)
    other.restore(twin.checkpoint())
    one, two = (each.advance(Command(0.0, 0.0), 0.02).energy for each in (twin, other))
    assert one == two
