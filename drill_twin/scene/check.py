# SPDX-License-Identifier: Apache-2.0
"""Consistency checks across the parts of a scene: string, hole, rig and effects.

The requirements of an effect stand in its own file (`drill_twin.physics.effects.EffectConfig.check_against`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import partial
from typing import TYPE_CHECKING, Any, get_args

from drill_twin.physics.effects.config import BitReaction, EffectConfig, Incompatibility
from drill_twin.scene.blocks.effects import Effects
from drill_twin.scene.blocks.hole import Hole
from drill_twin.scene.blocks.rig import Rig
from drill_twin.scene.blocks.section import Section
from drill_twin.scene.blocks.sensors import Sub, Surface
from drill_twin.scene.blocks.string import String

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
    """Stand-in for an invalid part: whatever a check asks of it raises UnknownPartError."""

    def __getattr__(self, name: str) -> Any:
        """Raise UnknownPartError."""
        raise UnknownPartError(name)


def contradictions(scene: Scene) -> Iterator[Incompatibility]:
    """Yield all contradictions between the parts of a scene; checks that meet an UnknownPart end early.

    Args:
        scene: Scene with valid parts, or with an UnknownPart in the place of each invalid one.
    """
    effects = scene.effects
    checks: list[Callable[[], Iterator[Incompatibility]]] = [
        lambda: _string_fits_the_hole(scene.string, scene.hole),
        lambda: _hole_holds_the_string(scene.string, scene.hole, effects),
        lambda: _formulation_is_whole(effects),
        lambda: _one_law_at_the_bit(effects),
        lambda: _string_carries_the_load(scene.string, scene.rig, effects),
        lambda: _top_can_turn(scene.rig, effects),
        lambda: _block_can_move(scene.rig, effects),
        lambda: _bit_is_held(scene.string, effects),
        lambda: _sensors_fit(scene),
        lambda: _may_follow_the_hole(scene),
        *(partial(_required_are_listed, key, block, effects) for key, block in _blocks(effects)),
        *(partial(_effect_fits, key, block, scene) for key, block in _blocks(effects)),
    ]
    for each in checks:
        with suppress(UnknownPartError):
            yield from each()


NEED_LATERAL = ("fatigue", "top_shake")
"""Effects that need lateral motion of the whole string."""


def _may_follow_the_hole(scene: Scene) -> Iterator[Incompatibility]:
    numerics, effects = scene.numerics, scene.effects
    depth = numerics.lateral_from
    if depth == 0.0:
        return
    if depth != "auto" and depth >= scene.string.length:
        yield Incompatibility(
            ("numerics", "lateral_from"),
            f"expected a depth above the bit ({scene.unit_system.text(scene.string.length, 'length')}), found "
            f"{scene.unit_system.text(depth, 'length')}",
        )
    found = [f"effects.{key}" for key in NEED_LATERAL if key in effects.blocks]
    found += ["effects.lateral_kick.offset"] if effects.lateral_kick is not None and effects.lateral_kick.offset else []
    found += ["no stretch and torsion"] if effects.stretch is None else []
    found += ["numerics.accuracy"] if numerics.accuracy is not None else []
    found += [f"rig.start: {scene.rig.start}"] if scene.rig.start != "axis" else []
    if found:
        yield Incompatibility(
            ("numerics", "lateral_from"),
            f"expected 0 m, the whole string, as a string that follows the hole has no lateral motion for them, found "
            f"{', '.join(found)}",
        )


def _blocks(effects: Effects) -> list[tuple[str, EffectConfig]]:
    try:
        return list(effects.blocks.items())
    except UnknownPartError:
        return []


def _effect_fits(key: str, block: EffectConfig, scene: Scene) -> Iterator[Incompatibility]:
    for place, text in block.check_against(scene):
        yield Incompatibility(("effects", key, *place), text)


def _string_fits_the_hole(string: String, hole: Hole) -> Iterator[Incompatibility]:
    top = string.length
    for index, section in enumerate(string.sections):
        top, bottom = max(top - section.length, 0.0), top
        narrow = hole.least_radius(top, bottom)
        for key, diameter in _diameters(section):
            if diameter >= 2.0 * narrow:
                yield Incompatibility(
                    ("string", "sections", index, *key),
                    f"expected less than the diameter of the hole ({2.0 * narrow:.6g} m), found {diameter:.6g} m",
                )


def _diameters(section: Section) -> Iterator[tuple[tuple[str, ...], float]]:
    yield ("outer_diameter",), section.outer_diameter
    if section.blade_diameter is not None:
        yield ("blade_diameter",), section.blade_diameter
    if section.joints is not None:
        yield ("joints", "diameter"), section.joints.diameter


def _hole_holds_the_string(string: String, hole: Hole, effects: Effects) -> Iterator[Incompatibility]:
    if not hole.survey:
        return
    if hole.survey[-1].depth < string.length * (1.0 - 1e-12):
        yield Incompatibility(
            ("hole", "survey", len(hole.survey) - 1, "depth"),
            f"expected the last station at or below the bit ({string.length:.6g} m), "
            f"found {hole.survey[-1].depth:.6g} m",
        )
    if effects.stretch is None and effects.torsion is None:
        yield Incompatibility(
            ("hole", "survey"),
            "expected `stretch` and `torsion` to be listed with a survey, found neither: "
            "the motion across the hole alone is computed in a straight hole only (`hole.inclination`)",
        )


def _formulation_is_whole(effects: Effects) -> Iterator[Incompatibility]:
    missing = [key for key in TOGETHER if getattr(effects, key) is None]
    if len(missing) == 1:
        listed = next(key for key in TOGETHER if key not in missing)
        yield Incompatibility(
            ("effects", listed),
            f"expected both or neither of `{TOGETHER[0]}` and `{TOGETHER[1]}`, found no `{missing[0]}`: list it too, "
            "or take both out for lateral motion only, with the axial force in balance and the spin of the top drive",
        )


def _required_are_listed(key: str, block: EffectConfig, effects: Effects) -> Iterator[Incompatibility]:
    for needed in block.requires:
        if getattr(effects, needed) is None:
            yield Incompatibility(
                ("effects", key), f"expected `{needed}` to be listed too, found it missing: {key} needs {needed}"
            )


def _one_law_at_the_bit(effects: Effects) -> Iterator[Incompatibility]:
    for what in get_args(BitReaction):
        laws = effects.providing(what)
        if len(laws) > 1:
            yield Incompatibility(
                ("effects", laws[1]),
                f"expected one law of the rock's {what} on the bit, found {' and '.join(laws)}",
            )


def _bit_is_held(string: String, effects: Effects) -> Iterator[Incompatibility]:
    if string.bit_end == "stabilised" and effects.bit_stabiliser is None:
        yield Incompatibility(
            ("string", "bit_end"),
            "expected `string.bit_end: stabilised` and `effects.bit_stabiliser` together, "
            "found bit_end stabilised without a bit_stabiliser",
        )


def _string_carries_the_load(string: String, rig: Rig, effects: Effects) -> Iterator[Incompatibility]:
    gravity = effects.gravity.magnitude if effects.gravity is not None else 0.0
    weight = gravity * sum(section.mass_per_length * section.length for section in string.sections)
    number, weakest = min(enumerate(string.sections), key=lambda item: item[1].youngs_modulus * item[1].area)
    stiffness = weakest.youngs_modulus * weakest.area
    for key in ("value", "initial"):
        load = abs(getattr(rig.weight_on_bit, key))
        if load + weight > LARGEST_STRAIN * stiffness and load > 0.0:
            yield Incompatibility(
                ("rig", "weight_on_bit", key),
                f"expected at most {max(LARGEST_STRAIN * stiffness - weight, 0.0):.4g} N, found {load:.4g} N: with the "
                f"string's own {weight:.4g} N it strains section {number + 1} (E A = {stiffness:.4g} N) by "
                f"{100.0 * (load + weight) / stiffness:.3g} %, where nothing that strings are made of stays elastic",
            )


def _top_can_turn(rig: Rig, effects: Effects) -> Iterator[Incompatibility]:
    if rig.top_drive.model != "prescribed" and effects.torsion is None:
        yield Incompatibility(
            ("rig", "top_drive", "model"),
            f'expected "prescribed" in a scene without torsion, found "{rig.top_drive.model}": list `torsion` too',
        )


def _sensors_fit(scene: Scene) -> Iterator[Incompatibility]:
    if scene.sensors is None:
        return
    string, surface = scene.string, scene.sensors.surface
    places: list[tuple[tuple[str | int, ...], Sub | Surface]] = [
        (("subs", k), sub) for k, sub in enumerate(scene.sensors.subs)
    ]
    for place, instrument in [*places, *([] if surface is None else [(("surface",), surface)])]:
        for key, text in _instrument_fits(instrument, scene.numerics.frame_rate, scene.rig.duration):
            yield Incompatibility(("sensors", *place, key), text)
    for index, sub in enumerate(scene.sensors.subs):
        if sub.distance_from_bit > string.length * (1.0 + 1e-12):
            yield Incompatibility(
                ("sensors", "subs", index, "distance_from_bit"),
                f'expected "{sub.name}" on the string ({string.length:.6g} m long), '
                f"found {sub.distance_from_bit:.6g} m from the bit",
            )
        elif sub.radius > (outer := string.radius_at(sub.distance_from_bit)):
            yield Incompatibility(
                ("sensors", "subs", index, "radius"),
                f"expected a sensor inside the string (outer radius {outer:.6g} m there), found {sub.radius:.6g} m",
            )


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


def _block_can_move(rig: Rig, effects: Effects) -> Iterator[Incompatibility]:
    if rig.block is None:
        return
    if effects.stretch is None:
        yield Incompatibility(("rig", "block"), "expected `stretch` and `torsion` to be listed, found neither")
    needed = rig.block.off_bottom > 0.0 or rig.block.auto_driller is not None
    if needed and not effects.providing("weight"):
        yield Incompatibility(
            ("rig", "block"),
            "expected rock for the bit to come down on, found none: list `rock_floor`, `bit_cutting` with a "
            "`rock_stiffness`, or `bit_regenerative`",
        )
