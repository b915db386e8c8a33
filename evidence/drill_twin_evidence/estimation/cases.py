# SPDX-License-Identifier: Apache-2.0
"""Cases of the score of the estimator: scene, numbers that are free, what is measured, and what jumps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from drill_twin_studies.estimation import LOAD
from drill_twin_studies.fitting.sampling import Ranges

JUMP = 30.0
"""Time of a jump [s]."""
STIFFNESS = "string.sections.0.youngs_modulus"
"""Key of the stiffness of a string of one section: the estimator cannot have it free."""
TOLERANCES: Mapping[str, float] = {LOAD: 0.01}
"""Relative error from which a number that has jumped is found, by key; 0.05 for others."""
SIZES = 0.1, 0.2
"""Least and largest relative change of a number that jumps."""


@dataclass(frozen=True)
class Case:
    """Scene, its free numbers, and what is measured.

    Attributes:
        scene: Name of the scene.
        ranges: Free numbers; the hidden ones are drawn from the same ranges.
        members: Members by default.
        horizon: Horizon of the chance of whirl [s]; 0 s: none is computed.
        overrides: Changes to the scene.
        channels: What is measured.
        imu: A downhole sub, measured too if asked for, as in a scene's `sensors`.
        truths: Ranges of the hidden numbers where they are narrower, so that a number may jump within its range.
        jump: Keys of numbers, free or one of the scene, that become 10 to 20 % larger or smaller at `JUMP`, apart by a
            space; empty: none.
    """

    scene: str
    ranges: Ranges
    members: int = 64
    horizon: float = 0.0
    overrides: Mapping[str, float | str] = field(default_factory=dict)
    channels: Sequence[str] = ("torque", "hookload")
    imu: str = ""
    truths: Ranges | None = None
    jump: str = ""


_ERRORS = "accelerometer: {noise: 5 mm/s^2, bias: 0.05 m/s^2}, gyroscope: {noise: 0.06 deg/s, bias: 0.3 deg/s}"
_NEAR_BIT = f"name: near_bit, distance_from_bit: 1 m, radius: 6 mm, rate: 100 Hz, {_ERRORS}"
_ROD: Ranges = {
    "wall_friction.coefficient": (0.1, 0.4),
    "internal_damping.bending_time": (0.015, 0.07),
    "bit_friction.coefficient": (0.03, 0.2),
    LOAD: (0.75, 1.25),
}
_STICKING, _SLIDING = "bit_torque_stribeck.sticking", "bit_torque_stribeck.sliding"
_TORSION = Case(
    "two_mass",
    {_STICKING: (0.52, 0.95), _SLIDING: (0.3, 0.51), LOAD: (0.7, 1.3)},
    members=32,
    overrides={
        "wob": 55e3, "rig.top_drive.proportional_gain": 8000.0, "rig.top_drive.integral_gain": 3000.0,
        "rig.top_drive.torque_limit": 60e3, "rig.rotation.shape": "ramp", "rig.rotation.value": 2.5,
        "rig.rotation.initial": 0.0, "rig.rotation.start": 0.0, "rig.rotation.duration": 4.0,
        "numerics.step": "5 ms", "numerics.frame_rate": 10.0,
    },
    truths={_STICKING: (0.68, 0.78), _SLIDING: (0.35, 0.45), LOAD: (0.9, 1.08)},
)  # fmt: skip
"""A string in torsion alone, whose drive holds its speed."""
_BENCH = Case("pa6_bench", _ROD, horizon=4.0, imu=_NEAR_BIT)
_WALL, _BIT = "wall_friction.coefficient", "bit_friction.coefficient"
CASES: Mapping[str, Case] = {
    "torsion": _TORSION,
    "load_jump": replace(_TORSION, jump=LOAD),
    "friction_jump": replace(_TORSION, jump=_STICKING),
    "rock_jump": replace(_TORSION, jump=f"{_STICKING} {_SLIDING}"),
    "stiffness_jump": replace(_TORSION, jump=STIFFNESS),
    "pa6_bench": _BENCH,
    "pa6_load_jump": replace(_BENCH, jump=LOAD, truths={LOAD: (0.95, 1.05)}),
    "pa6_wall_friction_jump": replace(_BENCH, jump=_WALL, truths={_WALL: (0.19, 0.31)}),
    "pa6_bit_friction_jump": replace(_BENCH, jump=_BIT, truths={_BIT: (0.08, 0.15)}),
    "pa6_calm": replace(_BENCH, overrides={"wob": 10.0, "rpm": 36}),
    "stick_slip": Case(
        "two_mass",
        {
            "bit_torque_stribeck.sticking": (0.7, 0.9),
            "bit_torque_stribeck.decay": (0.4, 1.6),
            "internal_damping.torsion_time": (0.1, 0.4),
            LOAD: (0.9, 1.1),
        },
        overrides={"wob": 55e3},
        imu=f"name: near_bit, distance_from_bit: 0.05 m, rate: 50 Hz, {_ERRORS}",
    ),
    "bha": Case(
        "bha_full_size",
        {"wall_friction.coefficient": (0.1, 0.4), "internal_damping.bending_time": (0.5e-3, 2e-3), LOAD: (0.8, 1.2)},
        members=16,
        overrides={"numerics.elements": 40},
        imu=f"name: near_bit, distance_from_bit: 15 m, radius: 80 mm, rate: 100 Hz, {_ERRORS}",
    ),
}
"""Cases by name."""
