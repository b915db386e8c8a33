# SPDX-License-Identifier: Apache-2.0
"""Wall friction at one place: its direction on the true slip, its size, and the tangent that Newton's method is given.

The kernels are called as the time loop calls them, in a straight and in a curved hole.
"""

from typing import NamedTuple

import numpy as np
import pytest
from hole_scenes import ON_THE_WALL, bend, with_parts
from pydantic import ValidationError
from rod_scenes import DIAMETER, LINE_MASS

from drill_twin.core.compile.jit import as_python
from drill_twin.core.errors import SceneError
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.physics.effects import Effect, wall, wall_friction
from drill_twin.physics.model.strain import Point
from drill_twin.scene import Scene, load_scene
from drill_twin.scene.set_points.command import Command

PLACE, H2, CLEARANCE = 17, 1e-3, 0.01


class Both(NamedTuple):
    wall: wall.Parameters
    wall_friction: wall_friction.Parameters


LAWS = [{"decay": 1.0}, {"sign": "arctan", "decay": 1.0}, {"decay": 20.0, "sliding": 0.2},
        {"decay": 20.0, "sliding": 0.2, "exponent": 3.0}, {"sliding": 0.1, "static_speed": 0.1, "dynamic_speed": 1.0},
        {"decay": 20.0, "sliding": 0.2, "intervals": [{"top": 0.0, "bottom": 19.0, "coefficient": 0.15}]}]  # fmt: skip


def scene_of(hole: str, friction: dict[str, float]) -> Scene:
    radius = CLEARANCE + DIAMETER / 2
    holes = {"straight": {"radius": radius}, "curved": bend(40.0, 20.0, 0.3, 0.8, hole=radius)}
    effects = ON_THE_WALL | {"wall": {"stiffness": 1e7, "restitution": 0.6}, "wall_friction": friction}
    return with_parts(effects=effects, length=20.0, elements=20, step=2 * H2, hole=holes[hole])


def made(scene: Scene) -> tuple[Both, Twin]:
    twin = Twin(scene)
    effects = scene.effects
    return Both(
        wall.parameters(effects.wall, twin.model), wall_friction.parameters(effects.wall_friction, twin.model)
    ), twin


def evaluate(
    both: Both, twin: Twin, place: np.ndarray, rate: np.ndarray, half_step: float = H2
) -> tuple[np.ndarray, ...]:
    """Load and tangent after two iterations at the same state, over a step or at an instant; rates of x, y, z, spin."""
    law = Effect.of("wall_friction", twin.scene.effects.wall_friction)
    friction_load = as_python(getattr(wall_friction, law.function("distributed_load")))
    for count in range(2):
        load, stiff = np.zeros(4), np.zeros((4, 4))
        seen = dict.fromkeys(Point._fields, 0.0) | dict(zip("xyz", place, strict=True))
        seen |= dict(zip(("vx", "vy", "vz", "spin_rate"), rate, strict=True))
        seen |= {
            "element": PLACE // 2,
            "place": PLACE,
            "tz": 1.0,
            "first_iteration": count == 0,
            "iteration": float(count),
        }
        here = Point(**seen)
        friction_load(both, twin.rod, here, half_step, load, stiff)
    return load, stiff


def on_the_wall(twin: Twin, depth: float, angle: float) -> tuple[np.ndarray, np.ndarray]:
    """A place in contact, and the directions round the hole, along it and outward there, as rows."""
    axis = twin.model.wellbore.axis
    centre, t = (np.array([0.0, 0.0, -9.0]), np.array([0.0, 0.0, 1.0])) if axis is None else (
        axis.centre[PLACE], axis.tangent[PLACE]
    )  # fmt: skip
    first = np.cross(t, [0.3, 0.5, 0.1])
    first /= np.linalg.norm(first)
    n = np.cos(angle) * first + np.sin(angle) * np.cross(t, first)
    return centre + (CLEARANCE + depth) * n, np.array([np.cross(t, n), t, n])


@pytest.mark.parametrize("hole", ["straight", "curved"])
@pytest.mark.parametrize(("around", "along"), [(0.3, 0.0), (0.0, -0.2), (0.3, 0.4), (-0.05, 0.6)])
def test_friction_opposes_the_slip(hole: str, around: float, along: float) -> None:
    """mu N / (1 + delta s) against the slip v.c + r psi_dot around and v.t along, and its couple on the spin."""
    mu, delta, spin = 0.3, 2.0, 5.0
    both, twin = made(scene_of(hole, {"coefficient": mu, "decay": delta}))
    place, (c, t, n) = on_the_wall(twin, 1e-4, 0.7)
    r = DIAMETER / 2
    rate = np.append((around - r * spin) * c + along * t, spin)
    load, _ = evaluate(both, twin, place, rate, half_step=0.0)
    slip = np.hypot(around, along)
    limit = mu / (1.0 + delta * slip) * 1e7 * 1e-4**1.5
    assert load[:3] == pytest.approx(-limit / slip * (around * c + along * t), rel=1e-6, abs=1e-9)
    assert load[3] == pytest.approx(-r * limit * around / slip, rel=1e-6, abs=1e-12)
    assert abs(load[:3] @ n) < 1e-9


@pytest.mark.parametrize("ratio", [0.1, 1.0, 10.0])
def test_the_law_near_zero_slip_is_the_documented_one(ratio: float) -> None:
    """v / sqrt(v^2 + c^2) with c = pi / (2 xi), at a steepness where the paper's arctan differs by up to 10 %."""
    mu, steepness = 0.3, 10.0
    both, twin = made(scene_of("straight", {"coefficient": mu, "accuracy": steepness}))
    place, (_, t, _) = on_the_wall(twin, 1e-4, 0.7)
    creep = np.pi / (2.0 * steepness)
    load, _ = evaluate(both, twin, place, np.append(ratio * creep * t, 0.0), half_step=0.0)
    assert load[:3] @ t == pytest.approx(-mu * 1e7 * 1e-4**1.5 * ratio / np.hypot(ratio, 1.0), rel=1e-9)


@pytest.mark.parametrize("ratio", [1e-6, 0.1, 1.0, 10.0])
def test_the_arctan_is_the_papers(ratio: float) -> None:
    """2/pi arctan(xi v) of the paper's Eq. 10, near zero slip too."""
    mu, steepness = 0.3, 10.0
    both, twin = made(scene_of("straight", {"coefficient": mu, "accuracy": steepness, "sign": "arctan"}))
    place, (_, t, _) = on_the_wall(twin, 1e-4, 0.7)
    slip = ratio * np.pi / (2.0 * steepness)
    load, _ = evaluate(both, twin, place, np.append(slip * t, 0.0), half_step=0.0)
    expected = -mu * 1e7 * 1e-4**1.5 * 2.0 / np.pi * np.arctan(steepness * slip)
    assert load[:3] @ t == pytest.approx(expected, rel=1e-7)


@pytest.mark.parametrize(("slip", "coefficient"), [(1e-3, 0.5), (0.01, 0.35), (10.0, 0.2003)])
def test_friction_falls_to_that_of_sliding(slip: float, coefficient: float) -> None:
    """mu_d + (mu - mu_d) / (1 + delta v): half of the excess is gone at v = 1 / delta."""
    friction = {"coefficient": 0.5, "sliding": 0.2, "decay": 100.0 if slip > 1e-3 else 1e-3}
    both, twin = made(scene_of("straight", friction))
    place, (_, t, _) = on_the_wall(twin, 1e-4, 0.7)
    load, _ = evaluate(both, twin, place, np.append(slip * t, 0.0), half_step=0.0)
    assert load[:3] @ t == pytest.approx(-coefficient * 1e7 * 1e-4**1.5, rel=1e-4)


def step(x: float, x0: float, h0: float, x1: float, h1: float) -> float:
    """The cubic STEP of ADAMS."""
    t = min(max((x - x0) / (x1 - x0), 0.0), 1.0)
    return h0 + (h1 - h0) * t * t * (3.0 - 2.0 * t)


@pytest.mark.parametrize("slip", [1e-6, 0.03, 0.0999, 0.1001, 0.4, 0.9, 5.0])
def test_static_and_dynamic_friction_are_joined_by_steps(slip: float) -> None:
    """The friction of a contact force of ADAMS: STEP(v, -v_s, mu_s, v_s, -mu_s), then STEP(v, v_s, mu_s, v_d, mu_d)."""
    mu, sliding, low, high = 0.5, 0.2, 0.1, 0.9
    law = {"coefficient": mu, "sliding": sliding, "static_speed": low, "dynamic_speed": high}
    both, twin = made(scene_of("straight", law))
    place, (_, t, _) = on_the_wall(twin, 1e-4, 0.7)
    load, _ = evaluate(both, twin, place, np.append(slip * t, 0.0), half_step=0.0)
    expected = step(slip, -low, -mu, low, mu) if slip < low else step(slip, low, mu, high, sliding)
    assert load[:3] @ t == pytest.approx(-expected * 1e7 * 1e-4**1.5, rel=1e-9)


@pytest.mark.parametrize(
    ("law", "said"),
    [
        ({"static_speed": 0.1}, "`static_speed` and `dynamic_speed` together"),
        ({"static_speed": 0.1, "dynamic_speed": 0.1}, r"`dynamic_speed` above `static_speed` \(0\.1 m/s\)"),
        (
            {"static_speed": 0.1, "dynamic_speed": 1.0, "decay": 1.0},
            "no `decay`, `exponent`, `sign` or `accuracy` beside",
        ),
    ],
)
def test_slip_speeds_that_join_nothing_are_refused(law: dict[str, float], said: str) -> None:
    with pytest.raises(ValidationError, match=said):
        scene_of("straight", {"coefficient": 0.3, **law})


@pytest.mark.parametrize("law", LAWS[:-1])
@pytest.mark.parametrize(("bottom", "scale"), [(19.0, 0.5), (1.0, 1.0)])
def test_an_interval_scales_the_whole_law(law: dict[str, float], bottom: float, scale: float) -> None:
    """Load and tangent in an interval of half the coefficient, and outside it: the place is 15.7 m deep of 20 m."""
    casing = {"intervals": [{"top": 0.0, "bottom": bottom, "coefficient": 0.15}]}
    found = []
    for own in ({}, casing):
        both, twin = made(scene_of("straight", {"coefficient": 0.3, **law, **own}))
        place, (c, t, _) = on_the_wall(twin, 1e-4, 0.7)
        found.append(evaluate(both, twin, place, np.append(0.03 * c + 0.02 * t, 0.0)))
    for plain, cased in zip(*found, strict=True):
        assert cased == pytest.approx(scale * plain, rel=1e-12, abs=1e-15)


@pytest.mark.parametrize(
    ("intervals", "said"),
    [
        ([("0 m", "3 m"), ("2 m", "4 m")], "expected at least 3 m, where the interval above ends, found 2 m"),
        ([("3 m", "3 m")], r"expected more than its top \(3 m\), found 3 m"),
    ],
)
def test_intervals_that_overlap_or_are_empty_are_refused(intervals: list[tuple[str, str]], said: str) -> None:
    rows = [{"top": top, "bottom": bottom, "coefficient": 0.1} for top, bottom in intervals]
    with pytest.raises(ValidationError, match=said):
        scene_of("straight", {"coefficient": 0.3, "intervals": rows})


def test_friction_that_slides_harder_than_it_sticks_is_refused() -> None:
    with pytest.raises(SceneError, match=r"expected `sliding` not above `coefficient` \(0\.2\), found 0\.3"):
        load_scene(
            "pa6_bench", overrides={"effects.wall_friction.coefficient": 0.2, "effects.wall_friction.sliding": 0.3}
        )


@pytest.mark.parametrize("hole", ["straight", "curved"])
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("slip", [(0.3, 0.4), (1e-7, 2e-7), (0.05, 0.0)])
def test_the_tangent_is_the_derivative(hole: str, law: dict, slip: tuple[float, float]) -> None:
    """Minus d load / d v minus half_step d load / d u, to 1e-3 of its largest, sliding and sticking, moving outward."""
    both, twin = made(scene_of(hole, {"coefficient": 0.3, **law}))
    place, (c, t, n) = on_the_wall(twin, 2e-4, -1.1)
    spin, r = 3.0, DIAMETER / 2
    rate = np.append((slip[0] - r * spin) * c + slip[1] * t + 0.01 * n, spin)
    _, stiff = evaluate(both, twin, place, rate)
    small = 1e-5 * max(np.hypot(*slip), 1e-7)
    for j in range(4):
        change = np.zeros(4)
        change[j] = small
        ahead, _ = evaluate(both, twin, place + H2 * change[:3], rate + change)
        behind, _ = evaluate(both, twin, place - H2 * change[:3], rate - change)
        assert stiff[:, j] == pytest.approx((behind - ahead) / (2.0 * small), abs=1e-3 * np.abs(stiff).max())


def test_rotation_frees_axial_sliding() -> None:
    """A string that lies in a horizontal hole carries a pull to the hook less mu w per metre; turned, it carries all.

    The friction of a turning string points round the hole; along it, a slow slide meets hardly any.
    """
    mu, length, pull = 0.3, 20.0, 40.0
    effects = ON_THE_WALL | {
        "gravity": {"magnitude": 9.81}, "drag": {"linear": 1.0}, "wall_friction": {"coefficient": mu},
        "internal_damping": {"bending_time": 0.02, "stretch_time": 2e-3, "torsion_time": 2e-3},
        "wall": {"stiffness": 1e7},
    }  # fmt: skip

    def hookload(speed: float) -> tuple[float, float]:
        scene = with_parts(
            effects=effects, length=length, elements=40, step=5e-3, radius=CLEARANCE + DIAMETER / 2,
            inclination=np.pi / 2,
        )  # fmt: skip
        twin = Twin(scene)
        for k in range(200):
            share = min((k + 1) / 100.0, 1.0) if speed else max((k - 99) / 100.0, 0.0)
            frame = twin.advance(Command(weight_on_bit=-pull * share, rotation=speed), 0.02)
        return frame.rig.hookload, frame.wall_force.sum()

    dragged, normal = hookload(0.0)
    assert normal == pytest.approx(LINE_MASS * 9.81 * length, rel=0.12)  # the ends carry the rest
    assert dragged == pytest.approx(pull - mu * normal, rel=0.02)
    assert hookload(10.0)[0] == pytest.approx(pull, rel=2e-3)
