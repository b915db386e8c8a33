# SPDX-License-Identifier: Apache-2.0
"""One set of effects for many checks, so that one kernel serves them all: each is listed but has nothing to do."""

from typing import Any

from drill_twin.scene import Scene
from drill_twin_evidence.verify.case import FORMS
from drill_twin_evidence.verify.scenes import FIRST, QUIET, rod_scene
from drill_twin_evidence.verify.signals import AT_REST, first_mode, rates, rotating_frame_response

__all__ = ["AT_REST", "FIRST", "FORMS", "QUIET", "first_mode", "quiet_scene", "rates", "rotating_frame_response"]


def quiet_scene(
    effects: dict[str, dict[str, Any]],
    *,
    form: str = "spatial",
    sections: tuple[dict[str, float], ...] = ({},),
    **scene: Any,
) -> Scene:
    """The paper's rod (or a changed one) with the effects given; the others are listed too, with nothing to do.

    Args:
        effects: Fields of effects.
        form: "lateral" leaves out stretch and torsion.
        sections: Fields of each section of the string that are not the rod's.
        scene: As for `scenes.rod_scene`.
    """
    listed = {key: block | effects.get(key, {}) for key, block in QUIET.items()}
    if effects.get("eccentricity", {}).keys() & {"sections", "rms"}:
        listed["eccentricity"] = effects["eccentricity"]
    return rod_scene(effects=listed, form=form, sections=sections, **scene)
