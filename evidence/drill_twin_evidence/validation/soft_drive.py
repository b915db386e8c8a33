# SPDX-License-Identifier: Apache-2.0
"""Stick-slip of a PDC bit under a stiff drive, a prescribed speed and soft ones, from rest.

`python -m drill_twin_evidence.validation.soft_drive` prints the table of `evidence/docs/bit_types.md`; string, weight
and damping are of `bit_types`. Nothing is tuned but by `rig.top_drive` itself.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.scene import Scene
from drill_twin.scene.set_points.command import Command
from drill_twin_evidence.validation.bit_types import LATE, SECONDS, SPIN_UP, WEIGHT, well

SOFT = {"model": "impedance", "inertia": 3000.0}
STIFF = {"model": "speed_controller", "inertia": 3000.0, "proportional_gain": 22e3, "integral_gain": 13e3}
DRIVES: dict[str, dict[str, Any]] = {
    "prescribed speed": {"model": "prescribed"},
    "speed controller": STIFF,
    "soft, inertia not cancelled": SOFT | {"cancelled_inertia": 0.0},
    "soft": SOFT,
    "soft, reflection of -0.3": SOFT | {"reflection": -0.3},
}


def late_speeds(drive: dict[str, Any], rpm: float) -> Array:
    """Speeds of bit and top at the end of a run [rpm], shape (F, 2)."""
    data = well("pdc", rpm).model_dump(exclude_none=True)
    data["rig"]["top_drive"] = drive
    twin, top = Twin(Scene.model_validate(data)), rpm * math.pi / 30.0
    ends = 0.02 * np.arange(1, round(SECONDS / 0.02) + 1)
    rows = [twin.advance(Command(WEIGHT, top * min(end / SPIN_UP, 1.0)), 0.02).rig for end in ends.tolist()]
    speeds = np.array([(row.bit_speed, row.top_drive_speed) for row in rows]) * 30.0 / math.pi
    return np.asarray(speeds[ends > SECONDS - LATE])


def main() -> None:
    """Print the table."""
    print("| drive | set-point | bit | top |\n| --- | --- | --- | --- |")
    for name, drive in DRIVES.items():
        for rpm in (90.0, 120.0):
            spans = (f"{speeds.min():.0f} to {speeds.max():.0f} rpm" for speeds in late_speeds(drive, rpm).T)
            print(f"| {name} | {rpm:.0f} rpm | {' | '.join(spans)} |", flush=True)


if __name__ == "__main__":
    main()
