# SPDX-License-Identifier: Apache-2.0
"""Checks across the parts of a scene: does the string fit the hole, do the effects go together."""

import math
from collections.abc import Iterator

from drill_twin.effects.bit_friction import BitFriction
from drill_twin.effects.eccentricity import Eccentricity
from drill_twin.scene.effects import Effects
from drill_twin.scene.hole import Hole
from drill_twin.scene.part import refuse_at
from drill_twin.scene.string import Section, String

TOGETHER = ("stretch", "torsion")
"""Effects whose unknowns come and go together: the string in space, or its lateral motion only."""

STEEPEST_START = 0.5
"""Largest slope of a string that starts off the axis."""


def check(string: String, hole: Hole, effects: Effects) -> None:
    """Refuse a scene whose parts contradict each other.

    Raises:
        ValidationError: names the place and both sides of the contradiction.
    """
    _string_fits_the_hole(string, hole)
    _hole_holds_the_string(string, hole, effects)
    _effects_go_together(effects)
    _imperfections_are_small(string, hole, effects)
    _mud_is_viscous(effects)
    _bit_can_slide(string, hole, effects)
    _start_is_in_the_hole(string, hole, effects)


def _string_fits_the_hole(string: String, hole: Hole) -> None:
    top = string.length
    for index, section in enumerate(string.sections):
        top, bottom = max(top - section.length, 0.0), top
        narrow = min(
            [hole.radius, *(i.radius for i in hole.intervals if i.top < bottom and i.bottom > top)]
        )  # the nominal radius counts even where intervals cover the section: between them lies the hole as drilled
        for key, diameter in _diameters(section):
            if diameter >= 2.0 * narrow:
                raise refuse_at(
                    ("string", "sections", index, *key),
                    f"expected less than the diameter of the hole ({2.0 * narrow:.6g} m), found {diameter:.6g} m",
                )


def _diameters(section: Section) -> Iterator[tuple[tuple[str, ...], float]]:
    yield ("outer_diameter",), section.outer_diameter
    if section.blade_diameter is not None:
        yield ("blade_diameter",), section.blade_diameter
    if section.joints is not None:
        yield ("joints", "diameter"), section.joints.diameter


def _hole_holds_the_string(string: String, hole: Hole, effects: Effects) -> None:
    if not hole.survey:
        return
    if hole.survey[-1].depth < string.length * (1.0 - 1e-12):
        raise refuse_at(
            ("hole", "survey", len(hole.survey) - 1, "depth"),
            f"expected the last station at or below the bit ({string.length:.6g} m), "
            f"found {hole.survey[-1].depth:.6g} m",
        )
    if effects.stretch is None and effects.torsion is None:
        raise refuse_at(
            ("hole", "survey"),
            "expected `stretch` and `torsion` to be listed with a survey, found neither: "
            "the motion across the hole alone is computed in a straight hole only (`hole.inclination`)",
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
    widest = max(piece.contact_diameter for piece in string.pieces) / 2.0
    clearance = min([hole.radius, *(i.radius for i in hole.intervals if i.top < string.length)]) - widest
    if effects.bow is not None and effects.bow.amplitude >= clearance:
        raise refuse_at(
            ("effects", "bow", "amplitude"),
            f"expected less than the clearance in the hole ({clearance:.6g} m), found {effects.bow.amplitude:.6g} m",
        )
    if effects.top_shake is not None and effects.top_shake.amplitude >= clearance:
        raise refuse_at(
            ("effects", "top_shake", "amplitude"),
            f"expected less than the clearance in the hole ({clearance:.6g} m), "
            f"found {effects.top_shake.amplitude:.6g} m",
        )
    if effects.eccentricity is not None:
        _mass_centres_are_inside(string, effects.eccentricity)


def _mass_centres_are_inside(string: String, eccentricity: Eccentricity) -> None:
    own = eccentricity.sections
    if own and len(own) != len(string.sections):
        raise refuse_at(
            ("effects", "eccentricity", "sections"),
            f"expected one item for each of the {len(string.sections)} sections of the string, found {len(own)}",
        )
    for index, section in enumerate(string.sections):
        offset = own[index].offset if own else eccentricity.offset or 0.0
        place = ("sections", index, "offset") if own else ("offset" if offset else "rms",)
        radius, found = section.outer_diameter / 2.0, offset + eccentricity.rms
        if found >= radius:
            raise refuse_at(
                ("effects", "eccentricity", *place),
                f"expected less than the outer radius ({radius:.6g} m), found {found:.6g} m",
            )


def _mud_is_viscous(effects: Effects) -> None:
    if effects.rotation_drag is not None and effects.mud is not None and effects.mud.viscosity == 0.0:
        raise refuse_at(
            ("effects", "rotation_drag"),
            "expected a viscosity above 0 Pa s in `mud`, found 0 Pa s: the torque comes from it",
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


def _start_is_in_the_hole(string: String, hole: Hole, effects: Effects) -> None:
    kick = effects.lateral_kick
    if kick is None or kick.offset == 0.0:
        return
    most = min(hole.radius, STEEPEST_START * string.length / math.pi)
    if abs(kick.offset) > most or hole.survey:
        found = "one beside a survey" if hole.survey else f"{kick.offset:.6g} m"
        raise refuse_at(
            ("effects", "lateral_kick", "offset"),
            f"expected at most the radius of a straight hole and a slope of {STEEPEST_START:g} ({most:.6g} m), "
            f"found {found}",
        )
