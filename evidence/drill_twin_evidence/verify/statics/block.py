# SPDX-License-Identifier: Apache-2.0
"""The travelling block: tripping, slacking off, and the auto-driller."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from drill_twin.dynamics.torque_drag.analysis import analyse
from drill_twin.dynamics.torque_drag.soft_string import Operation
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.scene import Scene
from drill_twin.scene.set_points import Schedule
from drill_twin.scene.set_points.command import Command
from drill_twin_evidence.verify.case import case
from drill_twin_evidence.verify.row import TWIN, Row
from drill_twin_evidence.verify.scenes import DIAMETER, WALLED, drilled, quiet_scene

GRAVITY = 9.81
PIPE, AREA, YOUNG, DENSITY = 1000.0, math.pi / 4.0 * (0.127**2 - 0.1086**2), 206e9, 7850.0
LINES = 1e8
ENERGY, RADIUS, THRUST, BLADES = 60e6, 0.108, 0.6, 4
AXIAL = THRUST * ENERGY * RADIUS


def rig(rig: dict[str, Any]) -> Scene:
    """A kilometre of pipe in the block, above a sharp regenerative bit, in a vertical hole."""
    return Scene.model_validate({
        "name": "block",
        "string": {
            "sections": [{
                "length": PIPE, "outer_diameter": 0.127, "inner_diameter": 0.1086,
                "youngs_modulus": YOUNG, "poisson_ratio": 0.3, "density": DENSITY,
            }],
            "bit_end": "guided",
        },
        "hole": {"radius": 0.15},
        "rig": {"duration": 100.0, **rig},
        "effects": {
            "gravity": {"magnitude": GRAVITY}, "stretch": {}, "torsion": {},
            "internal_damping": {"bending_time": 1e-2, "stretch_time": 2e-2, "torsion_time": 1e-2},
            "bit_regenerative": {"radius": RADIUS, "specific_energy": ENERGY, "thrust": THRUST, "blades": BLADES},
        },
        "numerics": {"elements": 20, "step": 5e-3},
    })  # fmt: skip


@case(speed=(0.02, -0.02))
def tripping(speed: float) -> Iterator[Row]:
    """The paper's rod, pulled out of a hole at 60 degrees and run into it.

    Mean of the fourth second: by then the rod has come to rest on the low side, and slides.
    """
    slope, friction = math.radians(60.0), 0.3
    effects = {
        "gravity": {"magnitude": GRAVITY}, "wall": {"stiffness": 1e7, "restitution": 0.1},
        "wall_friction": {"coefficient": friction}, "drag": {"linear": 5.0},
    }  # fmt: skip
    own = quiet_scene(effects, of=WALLED, radius=0.01 + DIAMETER / 2, inclination=slope, step=2e-3)
    still = analyse(own, [Operation("trip", 0.0, speed, 0.0)]).operations[0].balance.hookload
    data = own.model_dump(exclude_none=True)
    data["rig"] |= {"weight_on_bit": {"at": "block"}, "block": {"value": speed}}
    twin = Twin(Scene.model_validate(data))
    for _ in range(30):
        twin.advance(Command(0.0, 0.0, speed), 0.1)
    found = twin.advance(Command(0.0, 0.0, speed), 1.0).rig.hookload
    yield Row(
        "hookload [N]",
        "balance of the string that slides at this speed",
        f"{TWIN}drill-twin statics",
        still,
        found,
        1e-3,
    )


@case()
def slack_off() -> Iterator[Row]:
    """A vertical string, lowered by 5 cm/s onto rock 10 cm below, then held.

    Lines, pipe and the standing bit's cutters are springs in series. Axial waves are damped by the pipe: mean of 2 s.
    """
    twin = Twin(rig({"weight_on_bit": {"at": "block"}, "block": {"value": -0.05, "off_bottom": 0.1}}))
    weight = DENSITY * AREA * GRAVITY * PIPE
    twin.dynamics.command[2] = -0.05
    for _ in range(19):
        twin.advance(Command(0.0, 0.0, -0.05), 0.1)
    twin.dynamics.command[2] = 0.0
    for _ in range(20):
        twin.advance(Command(0.0, 0.0, 0.0), 0.5)
    hanging = twin.advance(Command(0.0, 0.0, 0.0), 2.0).rig
    yield Row("hookload off bottom [N]", "w L", "balance", weight, hanging.hookload, 1e-5)
    twin.dynamics.command[2] = -0.05
    for _ in range(41):
        twin.advance(Command(0.0, 0.0, -0.05), 0.1)
    twin.dynamics.command[2] = 0.0
    for _ in range(20):
        twin.advance(Command(0.0, 0.0, 0.0), 0.5)
    down = twin.advance(Command(0.0, 0.0, 0.0), 2.0).rig
    set_down = 0.2 / (1.0 / LINES + PIPE / (YOUNG * AREA) + 1.0 / (BLADES * AXIAL))
    yield Row("weight on bit after 30 cm [N]", "20 cm / (1 / k + L / EA + 1 / (n zeta eps a))", "springs in series",
              set_down, down.bit_force, 1e-3)  # fmt: skip
    yield Row("hookload and weight on bit [N]", "w L", "balance", weight, down.hookload + down.bit_force, 1e-5)


SET_POINTS: dict[str, tuple[dict[str, float], float]] = {
    "weight": ({"rate": 0.05}, 20e3), "rate": ({"rate": 5e-3}, 60e3),
    "torque": ({"rate": 0.05, "torque": 1000.0}, 60e3),
}  # fmt: skip
"""Fields of the auto-driller, and the weight to hold [N], by what is held."""


@case(holds=tuple(SET_POINTS))
def auto_driller(holds: str) -> Iterator[Row]:
    """From 5 cm off bottom onto rock, at 20 rad/s: what is held has no steady error.

    Mean of 50 s after 100; the bit vibrates on, and the mean varies with it.
    """
    driller, weight = SET_POINTS[holds]
    own = rig({
        "weight_on_bit": {"at": "block", "shape": "ramp", "initial": 0.0, "value": weight, "duration": 1.0},
        "rotation": {"shape": "ramp", "value": 20.0, "duration": 5.0},
        "top_drive": {"model": "impedance", "inertia": 1000.0},
        "block": {"off_bottom": 0.05, "auto_driller": driller},
    })  # fmt: skip
    twin, planned = Twin(own), Schedule.from_scene(own)
    for frame in range(1, 201):
        twin.advance(planned.at(0.5 * frame), 0.5)
    begun = drilled(twin)
    state = twin.advance(planned.at(150.0), 50.0).rig
    found = {"weight": state.bit_force, "rate": (drilled(twin) - begun) / 50.0, "torque": state.top_drive_torque}[holds]
    expected = {"weight": weight, "rate": driller["rate"], "torque": driller.get("torque", 0.0)}[holds]
    unit = {"weight": "N", "rate": "m/s", "torque": "N m"}[holds]
    yield Row(f"{holds} held [{unit}]", "set-point", "no steady error", expected, found, 2e-3)
