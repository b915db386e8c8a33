# SPDX-License-Identifier: Apache-2.0
"""Cases: the hard scenes, each in the formulations that it permits."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache

from drill_twin.core.errors import SceneError
from drill_twin.scene import Scene, added_scenes, load_scene

SPATIAL, LATERAL = "spatial", "lateral"
QUICK_LIMIT = 100.0
"""Simulated time above which a case is left out of the quick run [s]."""
EXPECTED_STOPS = {"hard/folds": "folded back", "hard/kick_into_the_wall": "effects.lateral_kick.offset"}
"""Scenes that must stop with an error, and a part of its message."""
LARGE_SLOPES = frozenset({"hard/clearance_10_m", "hard/folds"})
"""Scenes with slopes of order one; the lateral formulation is for small slopes."""


@dataclass(frozen=True)
class HardCase:
    """A hard scene in one formulation."""

    scene_name: str
    """Name for `drill-twin run`, as `hard/load_300_n`."""
    form: str
    """`spatial` or `lateral`."""
    why: str
    """Reason why the scene is hard, in one line."""
    seconds: float
    """Simulated time [s]."""

    @property
    def name(self) -> str:
        """Name of the case, as `load_300_n[spatial]`."""
        return f"{self.scene_name.removeprefix('hard/')}[{self.form}]"

    @property
    def long(self) -> bool:
        """True if `--quick` leaves the case out."""
        return self.seconds > QUICK_LIMIT

    def scene(self, *, energy: bool = False) -> Scene:
        """The scene in this formulation, with the energy audit if `energy`."""
        audit = {"numerics.audit": "energy"} if energy else {}
        return load_scene(self.scene_name, overrides=_form(self.form) | audit)


@cache
def all_hard_cases() -> tuple[HardCase, ...]:
    """Every case: each scene in the spatial formulation, and in the lateral one where it permits that.

    Raises:
        SceneError: A scene of the library is invalid.
    """
    return tuple(case for name in added_scenes("hard") for case in _forms_of(name))


def _forms_of(name: str) -> Iterator[HardCase]:
    scene = load_scene(name)
    for form in (SPATIAL, LATERAL):
        if form == SPATIAL or _permits_lateral(name):
            yield HardCase(name, form, " ".join(scene.description.split()), scene.rig.duration)


def choose_hard(pattern: str = "", *, quick: bool = False) -> list[HardCase]:
    """Cases whose name contains the pattern; `quick` leaves out those of more than 100 simulated seconds."""
    return [case for case in all_hard_cases() if pattern in case.name and not (quick and case.long)]


def _form(form: str) -> dict[str, str]:
    return {} if form == SPATIAL else {"effects.stretch": "off", "effects.torsion": "off"}


def _permits_lateral(name: str) -> bool:
    if name in LARGE_SLOPES:
        return False
    try:
        load_scene(name, overrides=_form(LATERAL))
    except SceneError:  # an effect or a drive that needs stretch or torsion
        return False
    return True
