# SPDX-License-Identifier: Apache-2.0
"""Simulated cases: runs of the paper's bench with random loads, ends, friction, damping and imperfections."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from drill_twin_evidence.detection.runs import Run, simulate

HEIGHTS = (4.4, 3.5, 2.5, 1.5, 0.5, 0.05)
"""Wall marks of these runs [m from the bit]: closer than half the pitch of a helix, and one at the bit."""
CHOICES = {
    "string.bit_end": ("pinned", "sliding", "guided", "free"),
    "rig.weight_on_bit.value": ("6 N", "12 N", "16 N", "25 N", "40 N", "100 N"),
    "rig.rotation.value": ("2 rev/s", "3 rev/s", "4 rev/s", "6 rev/s"),
    "hole.radius": ("60 mm", "90 mm"),
    "effects.wall_friction.coefficient": ("0", "0.05", "0.3", "0.6"),
    "effects.wall.restitution": ("0.5", "0.95"),
    "effects.drag.linear": ("0.1 N s/m^2", "0.3 N s/m^2"),
    "effects.internal_damping.bending_time": ("0.2 ms", "4 ms", "20 ms"),
    "effects.eccentricity.offset": ("0.1 mm", "0.3 mm"),
    "effects.bow.amplitude": ("1 mm", "3 mm"),
}
"""Values to draw from; frame rate, mesh and effects stay those of the scene."""
RAMPS = {
    "rig.rotation.duration": "2 s",
    "rig.weight_on_bit.start": "4 s",
    "rig.weight_on_bit.duration": "12 s",
    "rig.duration": "32 s",
}
"""Ramps that start off bottom: in the first revolutions a bow and a whirl cannot be told apart."""


BENCH: tuple[dict[str, str], ...] = (
    *({"wob": f"{force} N"} for force in (5, 20, 40, 100)),
    *({"rpm": f"{speed} rev/s"} for speed in (1, 4, 6)),
    *({"effects.wall_friction.coefficient": value} for value in ("0.1", "0.3")),
    {"effects.wall_friction.coefficient": "0.3", "rpm": "4 rev/s"},
    {"effects.wall_friction.coefficient": "0.3", "wob": "100 N"},
    {"hole.radius": "45 mm"},
    {"hole.radius": "45 mm", "effects.wall_friction.coefficient": "0.2"},
    {"string.bit_end": "pinned"},
    {"string.bit_end": "pinned", "wob": "100 N"},
    {"string.bit_end": "pinned", "wob": "60 N", "effects.wall_friction.coefficient": "0.2"},
    {"string.bit_end": "pinned", "wob": "16 N", "effects.wall_friction.coefficient": "0.3"},
    {"string.bit_end": "guided"},
    {"string.bit_end": "guided", "wob": "25 N", "effects.wall_friction.coefficient": "0.3"},
    {"effects.drag.linear": "1 N s/m^2"},
)
"""The paper's bench, with one or two changes in each run."""
BOUNCING = {
    "rig.rotation.value": "6 rev/s",
    "hole.radius": "45 mm",
    "effects.wall_friction.coefficient": "0.3",
    "effects.wall.restitution": "0.95",
    "effects.drag.linear": "0.05 N s/m^2",
    "effects.eccentricity.offset": "1 mm",
    "effects.bow.amplitude": "10 mm",
}
"""A strongly bent, unbalanced string that bounces between elastic walls from the start."""


def bench(number: int, *, subs: bool = False) -> Run:
    """One of the `BENCH` runs, with the readings of subs where asked for."""
    changes = BENCH[number]
    label = ", ".join(f"{key.rpartition('.')[2]} {value}" for key, value in changes.items())
    return simulate(f"bench: {label}", {"string.marks": _marks(), **changes}, subs=subs)


def bouncing(seed: int, changes: Mapping[str, str] = MappingProxyType({}), *, subs: bool = False) -> Run:
    """A run of the `BOUNCING` string with a random end, load and damping, and other changes."""
    draw = np.random.default_rng([seed, 10])
    chosen = {
        key: str(CHOICES[key][int(draw.integers(len(CHOICES[key])))])
        for key in ("string.bit_end", "rig.weight_on_bit.value", "effects.internal_damping.bending_time")
    }
    label = ", ".join(chosen.values())
    overrides = {"string.marks": _marks(), **RAMPS, **BOUNCING, **chosen, **changes}
    return simulate(f"bouncing {seed}: {label}", overrides, subs=subs)


def _marks() -> str:
    marks = ", ".join(f"{{name: mark_{k + 1}, distance_from_bit: {height} m}}" for k, height in enumerate(HEIGHTS))
    return f"[{marks}]"


def random_overrides(seed: int) -> dict[str, str]:
    """Overrides of a random run, the same for the same seed."""
    draw = np.random.default_rng([seed, 9])
    chosen = {key: str(values[int(draw.integers(len(values)))]) for key, values in CHOICES.items()}
    return {"string.marks": _marks(), **RAMPS, **chosen}


def simulated(seed: int, *, subs: bool = False) -> Run:
    """The random run of a seed."""
    overrides = random_overrides(seed)
    label = ", ".join(value for key, value in overrides.items() if key in CHOICES)
    return simulate(f"drawn {seed}: {label}", overrides, subs=subs)
