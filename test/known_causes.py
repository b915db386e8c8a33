# SPDX-License-Identifier: Apache-2.0
"""Ten runs whose cause is known by construction, each with the causes that may be named."""

from __future__ import annotations

from collections.abc import Callable
from math import tau
from typing import Any, NamedTuple

from rod_scenes import FIRST, ROLLING, quiet_scene

from drill_twin.api import Result, Simulation
from drill_twin.scene import Scene, load_scene
from drill_twin_evidence.verify.contact.regenerative import scene as drag_bit
from drill_twin_evidence.verify.scenes import WALLED

SOON = {"wob": 5, "rig.weight_on_bit.duration": 2, "rig.rotation.duration": 2}
BENCH = {"severity.source": "a bench", "severity.lateral_rms": [0.1, 0.2, 0.5, 2.0]}
NO_DAMPING = {"internal_damping": {"bending_time": 0.0}}

UNBALANCE = "without bow and eccentricity"
DAMPING = "without internal damping"
FRICTION = "without wall friction"
SHAKEN = "without shaking of the top"
BIT = "without the fall of the bit's torque with speed"
CUTTING = "without the torque of cutting"
REGENERATION = "without regeneration at the bit"
STIFF = "with a top drive that holds its speed"
START = "held for"
BUCKLING = "at 0.5 of the weight"


class Known(NamedTuple):
    """A run and what causes its problem."""

    run: Callable[[], Result]
    causes: tuple[str, ...]
    """Beginnings of the changes that take the true cause, or a true condition of it, away."""


def two_mass(torque: dict[str, Any], duration: float, twist: float, drive: dict[str, Any] | None = None) -> Scene:
    """Torsion of two masses at 8 rad/s; the top drive holds its speed where no other is given.

    Args:
        torque: Effect of the bit's torque.
        duration: Of the run [s].
        twist: Damping time of the spring [s].
        drive: The top drive.
    """
    data = load_scene("two_mass").model_dump(mode="json", exclude_none=True)
    data["effects"].pop("bit_torque_stribeck")
    data["effects"] |= torque
    data["effects"]["bit_mass"]["damping"] = 0.0
    data["effects"]["internal_damping"]["torsion_time"] = twist
    data["rig"] |= {"duration": duration, "top_drive": drive or {"model": "prescribed"}}
    data["rig"]["rotation"] = {"shape": "ramp", "value": 8.0, "duration": 5.0}
    return Scene.model_validate(data)


def stribeck(sliding: float, sticking: float, decay: float) -> dict[str, Any]:
    """Torque of the bit that falls with speed."""
    return {"bit_torque_stribeck": {"radius": 0.155575, "sliding": sliding, "sticking": sticking, "decay": decay}}


def bench(**changes: Any) -> Callable[[], Result]:
    """Run of the bench at 5 N; changes by key with `__` for a dot."""
    return lambda: Simulation(
        "pa6_bench", {**SOON, **{key.replace("__", "."): value for key, value in changes.items()}}
    ).run()


def rod(effects: dict[str, Any], weight: float, **changes: Any) -> Callable[[], Result]:
    """Run of the rod in a narrow hole."""

    def run() -> Result:
        scene = quiet_scene(effects, of=WALLED | {key: {} for key in effects if key not in WALLED}, radius=0.04,
                            step=2e-3, weight_on_bit=weight)  # fmt: skip
        return Simulation(scene, {key.replace("__", "."): value for key, value in changes.items()}).run()

    return run


BRISK = {"rig.rotation.value": 5.0, "rig.rotation.duration": 0.5}
SOFT = {"model": "speed_controller", "inertia": 200, "proportional_gain": 5.0, "integral_gain": 50.0}
CASES = {
    "unbalance at a critical speed": Known(
        bench(rpm=52.2, effects__eccentricity__offset="8 mm", duration=12), (UNBALANCE,)
    ),
    "bow above the critical speed": Known(
        bench(
            rpm=62,
            effects__bow__amplitude="30 mm",
            effects__internal_damping__bending_time=0,
            duration=20,
            **{key.replace(".", "__"): value for key, value in BENCH.items()},
        ),
        (UNBALANCE,),
    ),
    "wall friction": Known(
        rod(
            {**ROLLING, **NO_DAMPING, "lateral_kick": {"velocity": 0.3, "shape": "hump"}, "bow": {"amplitude": 1e-4}},
            20.0,
            rpm=180,
            rig__duration=8,
        ),
        (FRICTION, BUCKLING),
    ),
    "buckling": Known(bench(wob=20, rpm=40, duration=20), (BUCKLING, FRICTION)),
    "shaken top": Known(
        rod(
            {**NO_DAMPING, "top_shake": {"amplitude": 2e-3, "frequency": FIRST / tau}, "drag": {"linear": 0.02}},
            0.1,
            rpm=40,
            rig__duration=20,
            **{key.replace(".", "__"): value for key, value in BENCH.items()},
        ),
        (SHAKEN,),
    ),
    "swing on the low side": Known(
        bench(
            rpm=60,
            hole__inclination="60 deg",
            effects__wall_friction__coefficient=0.5,
            duration=30,
            **{key.replace(".", "__"): value for key, value in BENCH.items()},
        ),
        (FRICTION,),
    ),
    "cutting": Known(lambda: Simulation(two_mass({"bit_cutting": {}}, 60.0, 0.05), {"wob": 100e3}).run(), (CUTTING,)),
    "soft top drive": Known(
        lambda: Simulation(two_mass(stribeck(0.5, 0.53, 0.3), 120.0, 0.05, SOFT)).run(), (STIFF, BIT)
    ),
    "regenerative bit": Known(
        lambda: Simulation(drag_bit(0.0, 4.0, 2e-3), {"rig.duration": 50, "effects.bit_mass.damping": 40.0}).run(),
        (REGENERATION,),
    ),
    "start-up": Known(lambda: Simulation(two_mass(stribeck(0.5, 0.5, 0.0), 22.0, 0.04), BRISK).run(), (START,)),
}
