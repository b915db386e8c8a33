# SPDX-License-Identifier: Apache-2.0
"""Scenes for the wall, the hole and the sections: the paper's rod with another hole or other sections."""

from typing import Any

from rod_scenes import WALLED, rod_scene

from drill_twin.scene import Scene

ON_THE_WALL: dict[str, Any] = {
    "gravity": {"magnitude": 0.0},
    "bow": {"amplitude": 0.0},
    "eccentricity": {"offset": 0.0},
    "drag": {"linear": 0.0},
    "internal_damping": {"bending_time": 0.0},
    "wall": {"stiffness": 1e7, "restitution": 1.0},
    "wall_friction": {"coefficient": 0.0},
    "bit_friction": WALLED["bit_friction"],
}
"""The effects of pa6_bench, hence no kernel of its own, for all tests of the wall; here all but the wall at zero."""
SETTLING: dict[str, Any] = {
    "drag": {"linear": 1.0},
    "internal_damping": {"bending_time": 0.02, "stretch_time": 2e-3, "torsion_time": 2e-3},
    "wall": {"stiffness": 1e7},
}
"""What brings a string to rest."""


def with_parts(  # noqa: PLR0913
    *,
    hole: dict[str, Any] | None = None,
    sections: list[dict[str, Any]] | None = None,
    section: dict[str, Any] | None = None,
    marks: list[dict[str, Any]] | None = None,
    rig: dict[str, Any] | None = None,
    **options: Any,
) -> Scene:
    """`rod_scene` with another hole, other sections (or one changed), and marks (none by default).

    Args:
        hole: The whole block.
        sections: Changes to the rod that make each section, from the bit up.
        section: Changes to the one section.
        marks: The whole list; none by default.
        rig: Changes to the rig.
        options: As `rod_scene` takes them.
    """
    scene = rod_scene(marks=(), **options).model_dump(exclude_none=True)
    base = scene["string"]["sections"][0]
    scene["string"]["sections"] = [base | change for change in sections or [section or {}]]
    scene["string"]["marks"] = marks or []
    scene["hole"] = hole or scene["hole"]
    scene["rig"] |= rig or {}
    return Scene.model_validate(scene)


def bend(radius: float, length: float, inclination: float = 0.0, azimuth: float = 0.0, hole: float = 0.02) -> dict:
    """A hole that builds inclination along one circular arc [m]."""
    stations = [
        {"depth": depth, "inclination": inclination + depth / radius, "azimuth": azimuth} for depth in (0.0, length)
    ]
    return {"radius": hole, "survey": stations}
