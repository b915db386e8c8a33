# SPDX-License-Identifier: Apache-2.0
"""Consistency checks across the parts of a scene: string, hole, rig and effects.

The requirements of an effect stand in its own file (`drill_twin.physics.effects.EffectConfig.check_against`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator
from contextlib import suppress
from functools import partial
from itertools import permutations
from typing import TYPE_CHECKING, Any, get_args

from drill_twin.physics.effects.config import BitReaction, EffectConfig, Problem, too_large
from drill_twin.scene.blocks.sensors import Sub, Surface
from drill_twin.scene.blocks.string import places_off_string

if TYPE_CHECKING:
    from drill_twin.scene.schema import Scene

TOGETHER = ("stretch", "torsion")
"""Effects that are listed both or not at all: the spatial formulation, or the lateral one."""
LARGEST_STRAIN = 0.05
"""Largest axial strain under the load [-]: steel yields at 0.5 %, polyamide at 3 %."""
EVEN = 1e-4
"""Largest share by which frames in a sample of an instrument may differ from a whole number [-]."""


class UnknownPartError(Exception):
    """A check asks for a part of the scene that is itself invalid."""


class UnknownPart:
    """Stand-in for a part that is invalid as a whole, or for some of its keys."""

    def __init__(self, rest: object = None, invalid: Collection[str] = ()) -> None:
        """Take the part without its invalid keys; None for a part that is invalid as a whole."""
        self._rest, self._invalid = rest, invalid

    def __getattr__(self, name: str) -> Any:
        """Attribute of the valid rest of the part.

        Raises:
            UnknownPartError: The attribute depends on what is invalid.
        """
        if self._rest is None or name in self._invalid:
            raise UnknownPartError(name)
        return getattr(self._rest, name)


def contradictions(scene: Scene) -> Iterator[Problem]:
    """Yield all contradictions between the parts of a scene; checks that meet an UnknownPart end early.

    Args:
        scene: Scene with valid parts, or with an UnknownPart in the place of each invalid one.
    """
    checks: list[Callable[[Scene], Iterator[Problem]]] = [
        _string_fits_the_hole, _hole_holds_the_string, _formulation_is_whole, _one_law_at_the_bit,
        _string_carries_the_load, _top_can_turn, _block_can_move, _bit_is_held, _sensors_fit, _may_follow_the_hole,
    ]  # fmt: skip
    with suppress(UnknownPartError):
        for key, block in scene.effects.blocks.items():
            checks += [partial(_required_are_listed, key, block), partial(_effect_fits, key, block)]
    for each in checks:
        with suppress(UnknownPartError):
            yield from each(scene)


def needs_lateral(scene: Scene) -> list[str]:
    """Keys of a scene that need lateral motion of the whole string (`numerics.lateral_from`)."""
    effects, kick = scene.effects, scene.effects.lateral_kick
    found = ["effects.top_shake"] if effects.top_shake is not None else []
    found += ["effects.lateral_kick.offset"] if kick is not None and kick.offset else []
    found += ["no stretch and torsion"] if effects.stretch is None else []
    return found + ([f"rig.start: {scene.rig.start}"] if scene.rig.holds_values else [])


def _may_follow_the_hole(scene: Scene) -> Iterator[Problem]:
    depth = scene.numerics.lateral_from
    if depth == "auto" or not depth:
        return
    if depth >= scene.string.length:
        yield (
            ("numerics", "lateral_from"),
            (
                f"expected a depth above the bit ({scene.unit_system.text(scene.string.length, 'length')}), found "
                f"{scene.unit_system.text(depth, 'length')}"
            ),
        )
    if found := needs_lateral(scene):
        yield (
            ("numerics", "lateral_from"),
            (
                f"expected 0 m, the whole string, which needs lateral motion for what the scene lists, found "
                f"{', '.join(found)}"
            ),
        )


def _effect_fits(key: str, block: EffectConfig, scene: Scene) -> Iterator[Problem]:
    for place, text in block.check_against(scene):
        yield ("effects", key, *place), text


def _string_fits_the_hole(scene: Scene) -> Iterator[Problem]:
    top = scene.string.length
    for index, section in enumerate(scene.string.sections):
        top, bottom = max(top - section.length, 0.0), top
        joint = 0.0 if section.joints is None else section.joints.diameter
        diameters = {
            ("outer_diameter",): section.outer_diameter, ("blade_diameter",): section.blade_diameter or 0.0,
            ("joints", "diameter"): joint,
        }  # fmt: skip
        narrow = 2.0 * scene.hole.least_radius(top, bottom)
        for key, diameter in diameters.items():
            place: tuple[str | int, ...] = ("string", "sections", index, *key)
            yield from too_large(place, diameter, narrow, "diameter of the hole", below=True)
    for index, disc in enumerate(scene.string.discs):
        hole = 2.0 * scene.hole.radius_at(max(scene.string.length - disc.distance_from_bit, 0.0))
        place = ("string", "discs", index, "outer_diameter")
        yield from too_large(place, disc.outer_diameter or 0.0, hole, "diameter of the hole", below=True)


def _hole_holds_the_string(scene: Scene) -> Iterator[Problem]:
    string, hole, effects = scene.string, scene.hole, scene.effects
    if not hole.survey:
        return
    if hole.survey[-1].depth < string.length * (1.0 - 1e-12):
        yield (
            ("hole", "survey", len(hole.survey) - 1, "depth"),
            (
                f"expected the last station at or below the bit ({string.length:.6g} m), "
                f"found {hole.survey[-1].depth:.6g} m"
            ),
        )
    if effects.stretch is None and effects.torsion is None:
        yield (
            ("hole", "survey"),
            (
                "expected `stretch` and `torsion` to be listed with a survey, found neither: "
                "the motion across the hole alone is computed in a straight hole only (`hole.inclination`)"
            ),
        )


def _formulation_is_whole(scene: Scene) -> Iterator[Problem]:
    for listed, missing in permutations(TOGETHER):
        if getattr(scene.effects, listed) is not None and getattr(scene.effects, missing) is None:
            yield (
                ("effects", listed),
                (
                    f"expected both or neither of `{TOGETHER[0]}` and `{TOGETHER[1]}`, found no `{missing}`: list it "
                    "too, or take both out for lateral motion only, with the axial force in balance and the spin of "
                    "the top drive"
                ),
            )


def _required_are_listed(key: str, block: EffectConfig, scene: Scene) -> Iterator[Problem]:
    for needed in block.requires:
        if getattr(scene.effects, needed) is None:
            yield ("effects", key), f"expected `{needed}` to be listed too, found it missing: {key} needs {needed}"


def _one_law_at_the_bit(scene: Scene) -> Iterator[Problem]:
    for reaction in get_args(BitReaction):
        first, *others = scene.effects.providing(reaction) or [""]
        if others:
            text = f"expected one law of the rock's {reaction} on the bit, found {' and '.join((first, *others))}"
            yield ("effects", others[0]), text


def _bit_is_held(scene: Scene) -> Iterator[Problem]:
    end, lacks = scene.string.bit_end, scene.effects.bit_stabiliser is None
    if (end == "stabilised") is lacks:
        yield (
            ("string", "bit_end") if lacks else ("effects", "bit_stabiliser"),
            (
                "expected `string.bit_end: stabilised` and `effects.bit_stabiliser` together, "
                f"found bit_end {end} {'without' if lacks else 'with'} a bit_stabiliser"
            ),
        )


def _string_carries_the_load(scene: Scene) -> Iterator[Problem]:
    string, gravity = scene.string, scene.effects.gravity.magnitude if scene.effects.gravity is not None else 0.0
    weight = gravity * sum(section.mass_per_length * section.length for section in string.sections)
    weight += gravity * sum(string.body_of(disc)[0] for disc in string.discs)
    number, weakest = min(enumerate(string.sections), key=lambda item: item[1].youngs_modulus * item[1].area)
    stiffness = weakest.youngs_modulus * weakest.area
    for key in ("value", "initial"):
        load = abs(getattr(scene.rig.weight_on_bit, key))
        if load + weight > LARGEST_STRAIN * stiffness and load > 0.0:
            yield (
                ("rig", "weight_on_bit", key),
                (
                    f"expected at most {max(LARGEST_STRAIN * stiffness - weight, 0.0):.4g} N, found {load:.4g} N: with "
                    f"the string's own {weight:.4g} N it strains section {number + 1} (E A = {stiffness:.4g} N) by "
                    f"{100.0 * (load + weight) / stiffness:.3g} %, where nothing that strings are made of stays elastic"
                ),
            )


def _top_can_turn(scene: Scene) -> Iterator[Problem]:
    if (model := scene.rig.top_drive.model) != "prescribed" and scene.effects.torsion is None:
        text = f'expected "prescribed" in a scene without torsion, found "{model}": list `torsion` too'
        yield ("rig", "top_drive", "model"), text


def _sensors_fit(scene: Scene) -> Iterator[Problem]:
    if scene.sensors is None:
        return
    subs = scene.sensors.subs
    places: dict[tuple[str | int, ...], Sub | Surface] = {("subs", index): sub for index, sub in enumerate(subs)}
    if scene.sensors.surface is not None:
        places[("surface",)] = scene.sensors.surface
    for place, instrument in places.items():
        for key, text in _instrument_fits(instrument, scene.numerics.frame_rate, scene.rig.duration):
            yield ("sensors", *place, key), text
    for place, text in places_off_string("subs", subs, scene.string.length):
        yield ("sensors", *place), text
    for index, sub in enumerate(subs):
        if sub.distance_from_bit <= scene.string.length and sub.radius > (
            outer := scene.string.radius_at(sub.distance_from_bit)
        ):
            text = f"expected a sensor inside the string (outer radius {outer:.6g} m there), found {sub.radius:.6g} m"
            yield ("sensors", "subs", index, "radius"), text


def _instrument_fits(instrument: Sub | Surface, frame_rate: float, duration: float) -> Iterator[tuple[str, str]]:
    """Keys of an instrument that do not fit the frames or the run, with the reason."""
    rate, frames = instrument.rate, frame_rate / instrument.rate
    allowed = f"numerics.frame_rate ({frame_rate:.6g} Hz)"
    if rate > frame_rate * (1.0 + 1e-9):
        yield "rate", f"expected at most {allowed}, found {rate:.6g} Hz; a higher frame_rate allows it"
    elif abs(frames - round(frames)) > EVEN * frames:
        fitting = " or ".join(f"{frame_rate / count:.6g} Hz" for count in (math.ceil(frames), math.floor(frames)))
        text = f"expected {allowed} over a whole number, for even samples, found {rate:.6g} Hz; {fitting} fits"
        yield "rate", text
    elif rate * duration < 1.0:
        yield "rate", f"expected a sample within rig.duration ({duration:.6g} s), found {rate:.6g} Hz"
    if (delay := instrument.delay) >= duration:
        text = f"expected less than rig.duration ({duration:.6g} s), found {delay:.6g} s: no reading would come"
        yield "delay", text


def _block_can_move(scene: Scene) -> Iterator[Problem]:
    block, effects = scene.rig.block, scene.effects
    if block is None:
        return
    if effects.stretch is None:
        yield ("rig", "block"), "expected `stretch` and `torsion` to be listed, found neither"
    if (block.off_bottom > 0.0 or block.auto_driller is not None) and not effects.providing("weight"):
        yield (
            ("rig", "block"),
            (
                "expected rock for the bit to come down on, found none: list `rock_floor`, `bit_cutting` with a "
                "`rock_stiffness`, or `bit_regenerative`"
            ),
        )
