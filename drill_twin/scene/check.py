# SPDX-License-Identifier: Apache-2.0
"""Checks across the parts of a scene: does the string fit the hole, do the effects go together."""

from drill_twin.effects import BitFriction
from drill_twin.scene.effects import Effects
from drill_twin.scene.hole import Hole
from drill_twin.scene.part import refuse_at
from drill_twin.scene.string import String

TOGETHER = ("stretch", "torsion")
"""Effects whose unknowns come and go together: the string in space, or its lateral motion only."""


def check(string: String, hole: Hole, effects: Effects) -> None:
    """Refuse a scene whose parts contradict each other.

    Raises:
        ValidationError: names the place and both sides of the contradiction.
    """
    _string_fits_the_hole(string, hole)
    _effects_go_together(effects)
    _imperfections_are_small(string, hole, effects)
    _bit_can_slide(string, hole, effects)


def _string_fits_the_hole(string: String, hole: Hole) -> None:
    for index, section in enumerate(string.sections):
        if section.outer_diameter >= 2.0 * hole.radius:
            raise refuse_at(
                ("string", "sections", index, "outer_diameter"),
                f"expected less than the diameter of the hole ({2.0 * hole.radius:.6g} m), "
                f"found {section.outer_diameter:.6g} m",
            )


def _effects_go_together(effects: Effects) -> None:
    missing = [key for key in TOGETHER if getattr(effects, key) is None]
    if len(missing) == 1:
        listed = next(key for key in TOGETHER if key not in missing)
        raise refuse_at(
            ("effects", listed),
            f"expected both or neither of `{TOGETHER[0]}` and `{TOGETHER[1]}`, found no `{missing[0]}`: list it too, "
            "or take both out for lateral motion only, with the axial force in balance and the spin of the top drive",
        )
    for key, block in effects.blocks.items():
        for needed in block.needs:
            if getattr(effects, needed) is None:
                raise refuse_at(
                    ("effects", key), f"expected `{needed}` to be listed too, found it missing: {key} needs {needed}"
                )


def _imperfections_are_small(string: String, hole: Hole, effects: Effects) -> None:
    widest = max(section.outer_diameter for section in string.sections) / 2.0
    clearance = hole.radius - widest
    if effects.bow is not None and effects.bow.amplitude >= clearance:
        raise refuse_at(
            ("effects", "bow", "amplitude"),
            f"expected less than the clearance in the hole ({clearance:.6g} m), found {effects.bow.amplitude:.6g} m",
        )
    narrowest = min(section.outer_diameter for section in string.sections) / 2.0
    if effects.eccentricity is not None and effects.eccentricity.offset >= narrowest:
        raise refuse_at(
            ("effects", "eccentricity", "offset"),
            f"expected less than the outer radius ({narrowest:.6g} m), found {effects.eccentricity.offset:.6g} m",
        )


def _bit_can_slide(string: String, hole: Hole, effects: Effects) -> None:
    if effects.bit_friction is None:
        return
    if string.bit_end not in BitFriction.bit_ends:
        raise refuse_at(
            ("effects", "bit_friction"),
            f"expected `string.bit_end` to be {' or '.join(BitFriction.bit_ends)}, found {string.bit_end}: "
            "a bit held on the axis does not slide",
        )
    if effects.bit_friction.radius > hole.radius:
        raise refuse_at(
            ("effects", "bit_friction", "radius"),
            f"expected at most the radius of the hole ({hole.radius:.6g} m), found {effects.bit_friction.radius:.6g} m",
        )
