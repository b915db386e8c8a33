# SPDX-License-Identifier: Apache-2.0
"""Which hard scenes there are, and in which forms of the string each can be run."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache

from drill_twin.errors import SceneError
from drill_twin.scene import Scene, hard_scenes, load_scene

SPATIAL, LATERAL = "spatial", "lateral"
LONG = 100.0
"""Simulated time above which a case is left out of the quick run [s]."""
STOPS = {"hard/folds": "folded back"}
"""Scenes that no solver of this kind can follow to the end, and a word that the reason for stopping must hold."""
LARGE_SLOPES = frozenset({"hard/clearance_10_m", "hard/folds"})
"""Scenes whose slopes are of order one; the lateral form is for small ones."""


@dataclass(frozen=True)
class HardCase:
    """A hard scene in one form of the string."""

    scene_name: str
    """As `drill-twin run` takes it, such as `hard/load_300_n`."""
    form: str
    """`spatial` or `lateral`."""
    why: str
    """Why it is hard, in one line."""
    seconds: float
    """Simulated time [s]."""

    @property
    def name(self) -> str:
        """`load_300_n[spatial]`."""
        return f"{self.scene_name.removeprefix('hard/')}[{self.form}]"

    @property
    def long(self) -> bool:
        """Whether the quick run leaves it out."""
        return self.seconds > LONG

    def scene(self, *, energy: bool = False) -> Scene:
        """The scene in this form, with the energy audit if asked for."""
        audit = {"numerics.audit": "energy"} if energy else {}
        return load_scene(self.scene_name, overrides=_form(self.form) | audit)


@cache
def all_hard_cases() -> tuple[HardCase, ...]:
    """Every case: each scene in space, and across the hole only where it permits that.

    Raises:
        SceneError: A scene of the library is wrong.
    """
    return tuple(case for name in hard_scenes() for case in _forms_of(name))


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
    except SceneError:  # an effect or a drive that needs what the lateral form leaves out
        return False
    return True
