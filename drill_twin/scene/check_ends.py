# SPDX-License-Identifier: Apache-2.0
"""Checks of what acts on the two ends of the string: does it go with how they are held and driven."""

from drill_twin.effects.bit_side_force import BitSideForce
from drill_twin.scene.effects import Effects
from drill_twin.scene.hole import Hole
from drill_twin.scene.part import refuse_at
from drill_twin.scene.rig import Rig
from drill_twin.scene.string import String

TORQUES = ("bit_friction", "bit_cutting", "bit_torque_tanh", "bit_torque_stribeck")
"""Effects that each give the whole torque of the rock."""
CARRIERS = ("rock_floor", "bit_cutting")
"""Effects that carry a weight set at the top."""
LARGEST_STRAIN = 0.05
"""Axial strain that no load may ask for: steel yields at 0.5 %, polyamide at 3 %."""


def check_ends(string: String, hole: Hole, rig: Rig, effects: Effects) -> None:
    """Refuse a scene whose top drive, bit end and rock contradict each other.

    Raises:
        ValidationError: names the place and both sides of the contradiction.
    """
    _string_carries_the_load(string, rig, effects)
    _top_can_turn(rig, effects)
    _one_law_of_each(effects)
    _rock_carries_what_is_set_at_the_top(rig, effects)
    _stabiliser_is_at_the_bit(string, hole, effects)
    _force_moves_the_bit(string, effects)


def _string_carries_the_load(string: String, rig: Rig, effects: Effects) -> None:
    gravity = effects.gravity.magnitude if effects.gravity is not None else 0.0
    weight = gravity * sum(section.mass_per_length * section.length for section in string.sections)
    number, weakest = min(enumerate(string.sections), key=lambda item: item[1].youngs_modulus * item[1].area)
    stiffness = weakest.youngs_modulus * weakest.area
    for key in ("value", "initial"):
        load = abs(getattr(rig.weight_on_bit, key))
        if load + weight > LARGEST_STRAIN * stiffness and load > 0.0:
            raise refuse_at(
                ("rig", "weight_on_bit", key),
                f"expected at most {max(LARGEST_STRAIN * stiffness - weight, 0.0):.4g} N, found {load:.4g} N: with the "
                f"string's own {weight:.4g} N it strains section {number + 1} (E A = {stiffness:.4g} N) by "
                f"{100.0 * (load + weight) / stiffness:.3g} %, where nothing that strings are made of stays elastic",
            )


def _top_can_turn(rig: Rig, effects: Effects) -> None:
    if rig.top_drive.model != "prescribed" and effects.torsion is None:
        raise refuse_at(
            ("rig", "top_drive", "model"),
            f'expected "prescribed" in a scene without torsion, found "{rig.top_drive.model}": list `torsion` too',
        )


def _one_law_of_each(effects: Effects) -> None:
    for laws, what in ((TORQUES, "torque"), (CARRIERS, "weight")):
        listed = [key for key in laws if getattr(effects, key) is not None]
        if len(listed) > 1:
            raise refuse_at(
                ("effects", listed[1]),
                f"expected one law of the rock's {what} on the bit, found {' and '.join(listed)}",
            )


def _rock_carries_what_is_set_at_the_top(rig: Rig, effects: Effects) -> None:
    at = rig.weight_on_bit.at
    if effects.rock_floor is not None and at == "bit":
        raise refuse_at(
            ("effects", "rock_floor"),
            "expected `rig.weight_on_bit.at: top`, found bit: a weight prescribed at the bit needs no rock to carry it",
        )
    if effects.bit_cutting is not None:
        stiffness = effects.bit_cutting.rock_stiffness
        if at == "top" and stiffness is None:
            raise refuse_at(
                ("effects", "bit_cutting", "rock_stiffness"),
                'expected a stiffness such as "25e6 N/m" with `rig.weight_on_bit.at: top`, found none',
            )
        if at == "bit" and stiffness is not None:
            raise refuse_at(
                ("effects", "bit_cutting", "rock_stiffness"),
                "expected none with `rig.weight_on_bit.at: bit`, found one: such a weight needs no rock",
            )


def _stabiliser_is_at_the_bit(string: String, hole: Hole, effects: Effects) -> None:
    stabiliser = effects.bit_stabiliser
    if (stabiliser is not None) != (string.bit_end == "stabilised"):
        place = ("string", "bit_end") if stabiliser is None else ("effects", "bit_stabiliser")
        raise refuse_at(
            place,
            "expected `string.bit_end: stabilised` and `effects.bit_stabiliser` together, "
            f"found bit_end {string.bit_end} {'without' if stabiliser is None else 'with'} a bit_stabiliser",
        )
    if stabiliser is not None and stabiliser.gauge > 2.0 * hole.radius:
        raise refuse_at(
            ("effects", "bit_stabiliser", "gauge"),
            f"expected at most the diameter of the hole ({2.0 * hole.radius:.6g} m), found {stabiliser.gauge:.6g} m",
        )


def _force_moves_the_bit(string: String, effects: Effects) -> None:
    side = effects.bit_side_force
    if side is None:
        return
    for key, ends in (("force", BitSideForce.slides), ("moment", BitSideForce.tilts)):
        if getattr(side, key) != 0.0 and string.bit_end not in ends:
            raise refuse_at(
                ("effects", "bit_side_force", key),
                f"expected `string.bit_end` to be one of {', '.join(ends)}, found {string.bit_end}: "
                f"a {key} cannot move such a bit",
            )
