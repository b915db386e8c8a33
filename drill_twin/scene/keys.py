# SPDX-License-Identifier: Apache-2.0
"""Numbers of a scene by their keys."""

from drill_twin.scene.schema import Scene


def number_at(scene: Scene, key: str) -> float | None:
    """Value of a number of a scene in SI, by a key as `string.sections.0.length`; None if there is none."""
    found: object = scene
    for part in key.split("."):
        if isinstance(found, tuple):
            found = found[int(part)] if part.isdigit() and int(part) < len(found) else None
        else:
            found = getattr(found, part, None)
    return float(found) if isinstance(found, int | float) and not isinstance(found, bool) else None
