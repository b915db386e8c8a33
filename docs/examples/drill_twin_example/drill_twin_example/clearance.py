# SPDX-License-Identifier: Apache-2.0
"""Command `drill-twin clearance`: room of the string in the hole."""

from typing import Annotated

import typer


def clearance(
    scene: Annotated[str, typer.Argument(metavar="SCENE", help="An installed scene, or a scene file.")],
) -> None:
    """Print the radial clearance of each section of the string [mm]."""
    from drill_twin import load_scene  # here, so that `drill-twin --help` stays fast

    loaded = load_scene(scene)
    for number, section in enumerate(loaded.string.sections, 1):
        print(f"section {number}: {1e3 * (loaded.hole.radius - 0.5 * section.outer_diameter):.2f} mm")
