# SPDX-License-Identifier: Apache-2.0
"""Sets of effects that hold every pair of switches: on and on, on and off, off and off."""

import itertools
from functools import cache
from typing import Any

import numpy as np

from drill_twin.physics.effects import EFFECTS

SWITCHES: dict[str, dict[str, Any]] = {
    "gravity": {},
    "stretch": {},
    "bow": {"amplitude": 2e-3},
    "eccentricity": {"offset": 1e-4},
    "gyroscopic": {},
    "internal_damping": {"bending_time": 2e-3, "stretch_time": 1e-3, "torsion_time": 1e-3},
    "drag": {"linear": 0.1},
    "mud": {"density": 1000.0, "viscosity": 1e-3},
    "quadratic_drag": {},
    "added_mass": {"coefficient": 1.0},
    "rotation_drag": {},
    "viscous_drag": {},
    "wall": {"stiffness": 1e7},
    "wall_friction": {"coefficient": 0.2},
    "rock_floor": {"stiffness": 1e6, "damping": 100.0},
    "bit_cutting": {"cutting": 1e-5, "advance": 1e-5, "threshold": 1e-5, "rubbing": 0.01, "digging": 10.0},
    "bit_friction": {"coefficient": 0.3, "radius": 8e-3},
    "bit_torque_tanh": {"arm": 1e-3},
    "bit_torque_stribeck": {"radius": 8e-3, "sliding": 0.3, "sticking": 0.5, "decay": 0.5},
    "bit_regenerative": {"radius": 8e-3, "specific_energy": 1e6, "wear": 1e-4, "contact_strength": 1e6},
    "bit_mass": {"mass": 0.1, "inertia": 1e-5},
    "bit_stabiliser": {"gauge": 0.07, "stiffness": 1e5},
    "bit_side_force": {"force": 0.1},
    "lateral_kick": {"velocity": 0.2, "shape": "hump"},
    "random_force": {"rms": 0.05, "correlation_time": 0.2, "correlation_length": 1.0},
    "top_shake": {"amplitude": 1e-4, "frequency": 3.0},
}
"""What each effect is when it is on; `stretch` stands for torsion too."""
APART = ("bit_regenerative",)
"""Effects in sets of their own, after the others: each excludes many of those."""
EXCLUSIVE = (
    *(tuple(key for key, block in EFFECTS.items() if what in block.provides) for what in ("torque", "weight")),
    ("bit_friction", "bit_stabiliser"),
)
"""Effects of which a scene has at most one."""
Choice = frozenset[str]
_DRAWN = [key for key in SWITCHES if key not in APART]


def allowed(on: Choice) -> bool:
    """Whether a scene may list these together."""
    listed = on | ({"torsion"} if "stretch" in on else set())
    if any(set(EFFECTS[key].requires) - listed for key in on):
        return False
    return all(len(on & set(group)) <= 1 for group in EXCLUSIVE)


def pairs_of(on: Choice) -> set[tuple[str, bool, str, bool]]:
    """States of every two switches."""
    return {(a, a in on, b, b in on) for a, b in itertools.combinations(_DRAWN, 2)}


@cache
def covering() -> tuple[Choice, ...]:
    """Sets that hold every pair of states that any allowed set holds; greedy, from seeded draws."""
    random = np.random.default_rng(1)
    pool: list[Choice] = []
    for share in (0.25, 0.4, 0.55, 0.7):
        for _ in range(1500):
            drawn = {key for key in _DRAWN if random.random() < share}
            for group in EXCLUSIVE:
                drawn -= set(random.permutation(sorted(drawn & set(group)))[1:])
            listed = drawn | ({"torsion"} if "stretch" in drawn else set())
            drawn = {key for key in drawn if set(EFFECTS[key].requires) <= listed}
            if allowed(frozenset(drawn)):
                pool.append(frozenset(drawn))
    states = np.array([[key in on for key in _DRAWN] for on in pool])
    a, b = np.triu_indices(len(_DRAWN), 1)
    held = (2 * states[:, a] + states[:, b])[..., None] == np.arange(4)
    wanted = held.any(axis=0)
    chosen: list[Choice] = []
    while wanted.any():
        best = int(np.argmax((held & wanted).sum(axis=(1, 2))))
        chosen.append(pool[best])
        wanted &= ~held[best]
    return (*chosen, *(_with_all_others(key) for key in APART))


def _with_all_others(own: str) -> Choice:
    """An effect with all that it does not exclude."""
    found = {own}
    for key in ("stretch", *_DRAWN):
        if allowed(frozenset(found | {key})):
            found.add(key)
    return frozenset(found)
