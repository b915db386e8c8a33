# SPDX-License-Identifier: Apache-2.0
"""Scene: the complete input of a run, validated as a whole."""

import math
import re
from collections.abc import Iterator
from typing import Annotated, Literal, NamedTuple

import numpy as np
from pydantic import Field

from drill_twin.core.numerals import whole_number
from drill_twin.core.severity import DEFAULT, Bounds
from drill_twin.core.table import Shown, Table
from drill_twin.core.units.dimension import GRAVITY
from drill_twin.core.units.system import UnitSystem, unit_system
from drill_twin.physics.effects.config import Label, Part, Problem
from drill_twin.scene.blocks.effects import Effects
from drill_twin.scene.blocks.hole import Hole
from drill_twin.scene.blocks.numerics import Numerics
from drill_twin.scene.blocks.rig import Rig
from drill_twin.scene.blocks.sensors import Sensors
from drill_twin.scene.blocks.severity import SeverityBounds
from drill_twin.scene.blocks.string import String
from drill_twin.scene.check import contradictions
from drill_twin.scene.lines import yaml_text

TOLERANCE, LOSSLESS_TOLERANCE = 1e-5, 1e-6
"""Newton tolerance for `auto`, with a dissipative effect and without [-]."""


class MarkPlace(NamedTuple):
    """Place of a mark, as the whirl analysis needs it."""

    name: str
    """Name on the topics."""
    distance_from_bit: float
    """Arc length from the bit [m]."""
    on: str
    """`wall` or `centre`."""
    wall_offset: float
    """Distance of the mark from the centre line [m]: the outer radius (blades included) on the wall, 0 on the
    centre."""
    clearance: float
    """Lateral distance of the centred string from the wall [m]."""


class Scene(Shown, Part):
    """String, hole, rig, effects and numerics of a run; floats are SI, text in a file has its unit."""

    name: Annotated[Label, Field(min_length=1)]
    """Short name, used in titles and folders."""
    description: Annotated[str, Field(max_length=5000)] = ""
    """Purpose of the scene."""
    provenance: Annotated[str, Field(max_length=5000)] = ""
    """Source of the numbers; `stand-in` or `estimated` for numbers without measurement."""
    units: Literal["auto", "field", "si", "lab"] = "auto"
    """Units of tables, figures and pages. `auto`: `field` where the weight on bit is written in pounds, else `si`, or
    `lab` for a string of at most 100 m under less than 5 kN."""
    string: String
    """The drillstring and its marks."""
    hole: Hole
    """The hole around the drillstring."""
    rig: Rig
    """Set-points and duration."""
    effects: Effects
    """Effects to simulate."""
    numerics: Numerics = Numerics()
    """Resolution."""
    sensors: Sensors | None = None
    """Simulated measurements of a rig; left out: none."""
    severity: SeverityBounds | None = None
    """Bounds of the grades of severity; left out: bounds of this program."""

    def problems(self) -> Iterator[Problem]:
        """Contradictions between the parts."""
        yield from contradictions(self)

    @property
    def unit_system(self) -> UnitSystem:
        """Units in which people read this scene and its runs."""
        return unit_system(self.units, self.length, self.rig.weight_on_bit.value)

    @property
    def length(self) -> float:
        """Length of the string from bit to top clamp [m]."""
        return self.string.length

    def outer_radius_at(self, distance_from_bit: float) -> float:
        """Radius of the string's surface that meets the wall, at an arc length from the bit [m]."""
        return self.string.radius_at(distance_from_bit)

    def clearance_at(self, distance_from_bit: float) -> float:
        """Lateral distance of the centred string from the wall at an arc length from the bit [m]."""
        depth = max(self.length - distance_from_bit, 0.0)
        return self.hole.radius_at(depth) - self.outer_radius_at(distance_from_bit)

    def inclination_at(self, distance_from_bit: float) -> float:
        """Angle of the hole from the vertical at an arc length from the bit [rad], linear between two stations."""
        if not self.hole.survey:
            return self.hole.inclination
        depth, inclination, _ = self.hole.stations
        return float(np.interp(max(self.length - distance_from_bit, 0.0), depth, inclination))

    @property
    def least_clearance(self) -> float:
        """Smallest radius of the hole minus largest radius of the string [m]."""
        hole, widest = self.hole, max(piece.contact_diameter for piece in self.string.pieces) / 2.0
        return min([hole.radius, *(i.radius for i in hole.intervals if i.top < self.length)]) - widest

    @property
    def severity_bounds(self) -> Bounds:
        """Bounds of the grades of severity."""
        return self.severity.bounds if self.severity else DEFAULT

    @property
    def effect_names(self) -> list[str]:
        """Keys of the effects that are on."""
        return self.effects.names

    @property
    def tolerance(self) -> float:
        """Newton tolerance: `numerics.tolerance`, or the value chosen for `auto` [-]."""
        if self.numerics.tolerance != "auto":
            return self.numerics.tolerance
        return (
            LOSSLESS_TOLERANCE
            if all(block.energy_class == "kept" for block in self.effects.blocks.values())
            else TOLERANCE
        )

    @property
    def mark_table(self) -> tuple[MarkPlace, ...]:
        """Marks in the scene's order, with radius and clearance at their place."""
        return tuple(
            MarkPlace(
                name=mark.name,
                distance_from_bit=mark.distance_from_bit,
                on=mark.on,
                wall_offset=self.outer_radius_at(mark.distance_from_bit) if mark.on == "wall" else 0.0,
                clearance=self.clearance_at(mark.distance_from_bit),
            )
            for mark in self.string.marks
        )

    def shown(self) -> Table:
        """Rows of `scene_rows`, for a prompt and a notebook."""
        return Table((), scene_rows(self), title=f"{self.name}: {first_sentence(self.description)}".removesuffix(": "))

    def to_yaml(self) -> str:
        """Resolved scene as text, SI units and defaults written out; `parse_scene` reads it to an equal scene."""
        return yaml_text(self.model_dump(mode="json", exclude_none=True))


def first_sentence(text: str) -> str:
    """First sentence of a description."""
    return re.split(r"(?<=[.:]) ", " ".join(text.split()), maxsplit=1)[0].rstrip(":")


def set_points_of(scene: Scene) -> tuple[str, str]:
    """Weight on bit and speed of a scene in words."""
    force, turn, units = scene.rig.weight_on_bit, scene.rig.rotation, scene.unit_system
    largest, speed = units.text(force.value, "force"), units.text(turn.value, "rotation")
    return ("recorded" if force.shape == "table" else largest, "recorded" if turn.shape == "table" else speed)


def scene_rows(scene: Scene) -> Iterator[tuple[str, str]]:
    """Rows of names and values that tell people what a scene is."""
    force, turn = set_points_of(scene)
    string, units, n = scene.string, scene.unit_system, len(scene.string.sections)
    yield (
        "string",
        f"{units.text(scene.length, 'length')}, {n} section{'s' * (n > 1)}, bit end {string.bit_end}",
    )
    if heavy := [section for section in string.sections if section.adjusted_mass is not None]:
        weights = {one.name: units.text(one.mass_per_length * GRAVITY, "force_per_length") for one in heavy}
        yield "weight in air", ", ".join(f"{name} {weight}" for name, weight in weights.items())
    yield "marks", ", ".join(f"{mark.name} ({units.text(mark.distance_from_bit, 'length')})" for mark in string.marks)
    tilt = math.degrees(scene.hole.top_inclination)
    yield "hole", f"radius {units.text(scene.hole.radius, 'offset')}, inclined by {tilt:g} degrees at the top"
    if block := scene.rig.block:
        yield "block", "moved by the auto-driller" if block.auto_driller else units.text(block.value, "rate")
    if not block or block.auto_driller:
        yield "weight on bit", force
    yield "rotation", turn
    yield "duration", f"{scene.rig.duration:g} s"
    yield "effects", ", ".join(scene.effect_names)
    friction = getattr(scene.effects, "wall_friction", None)
    if friction and friction.intervals:
        cased = (f"{one.coefficient:g} from {units.span(one.top, one.bottom, 'length')}" for one in friction.intervals)
        yield "friction", f"{friction.coefficient:g}; {', '.join(cased)}"
    if scene.sensors:
        surface = ["surface"] if scene.sensors.surface else []
        yield "sensors", ", ".join([*(sub.name for sub in scene.sensors.subs), *surface])
    yield "elements, step", f"{scene.numerics.elements}, {scene.numerics.step}"


def number_at(scene: Scene, key: str) -> float | None:
    """Value of a number of a scene in SI, by a key as `string.sections.0.length`; None if there is none."""
    found = _reached(scene, key)
    return float(found) if isinstance(found, int | float) and not isinstance(found, bool) else None


def unit_at(scene: Scene, key: str) -> str:
    """SI unit of a number of a scene, by the same key; empty without one."""
    place, _, name = key.rpartition(".")
    fields = getattr(type(_reached(scene, place) if place else scene), "model_fields", {})
    kinds = fields[name].metadata if name in fields else []
    return next((str(kind.dimension.unit) for kind in kinds if hasattr(kind, "dimension")), "")


def _reached(scene: Scene, key: str) -> object:
    """Part of a scene at a key; None if there is none."""
    found: object = scene
    for part in key.split("."):
        if isinstance(found, tuple):
            found = None if (k := whole_number(part)) is None or k >= len(found) else found[k]
        else:
            found = getattr(found, part, None)
    return found
