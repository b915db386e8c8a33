# SPDX-License-Identifier: Apache-2.0
"""Sets of numbers and of readings of the bench: everything that the paper leaves open."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.errors import SceneError
from drill_twin.scene import Scene
from drill_twin_evidence.paper.runs.cases import DAMPING, Case, value_at


@dataclass(frozen=True)
class FreeParameter:
    """A number that the paper does not give, on a logarithmic scale."""

    place: str
    """Key in the scene; empty where it takes more than its value."""
    name: str
    """Name in tables."""
    unit: str
    """Unit in tables."""
    scale: float
    """Value of one `unit` in SI."""
    low: float
    """Lower bound [unit]."""
    high: float
    """Upper bound [unit]."""
    reason: str
    """Reason of the bounds."""
    also: tuple[str, ...] = ()
    """Other keys with the same value."""

    def value(self, fraction: float) -> float:
        """The value [SI] at a fraction, 0 to 1, of the way between the bounds."""
        return self.scale * self.low * math.exp(fraction * math.log(self.high / self.low))

    def fraction(self, value: float) -> float:
        """Position of a value [SI] between the bounds, clipped to 0 to 1."""
        inside = min(max(value / self.scale, self.low), self.high)
        return math.log(inside / self.low) / math.log(self.high / self.low)


FRACTION_LEFT = "share of friction left at high slip"
STATIC, DYNAMIC = "slip speed of static friction", "slip speed of dynamic friction over it"
PLAY, SPRING = "play of the bit", "stiffness of the bit's guide"
FREE = (
    FreeParameter("rig.weight_on_bit.duration", "ramp of the load", "s", 1.0, 0.5, 15.0, "not given"),
    FreeParameter("rig.weight_on_bit.start", "start of the load", "s", 1.0, 0.01, 4.0, "not given"),
    FreeParameter("rig.rotation.duration", "ramp of the rotation", "s", 1.0, 0.1, 14.0, "not given"),
    FreeParameter("effects.bow.amplitude", "bow", "mm", 1e-3, 0.01, 5.0,
                  "straight to the eye, or hung on two supports"),
    FreeParameter("effects.eccentricity.offset", "eccentricity", "mm", 1e-3, 0.01, 4.0,
                  "up to half the radius"),
    FreeParameter("effects.internal_damping.bending_time", "retardation time", "ms", 1e-3, 1.0, 60.0,
                  "loss factor 0.006 to 0.4 at 1 Hz", DAMPING[1:]),
    FreeParameter("effects.drag.linear", "drag", "N s/m^2", 1.0, 0.001, 0.3, "air, and a bench that rubs"),
    FreeParameter("effects.wall_friction.coefficient", "friction at the wall", "", 1.0, 0.01, 0.8,
                  "oiled to dry"),
    FreeParameter("effects.wall_friction.decay", "fall of friction with slip", "s/m", 1.0, 0.01, 30.0,
                  "Coulomb to a film at 0.03 m/s"),
    FreeParameter("", FRACTION_LEFT, "", 1.0, 0.02, 1.0, "static and dynamic friction"),
    FreeParameter("effects.bit_friction.coefficient", "friction at the bit", "", 1.0, 0.002, 0.5,
                  "ball to flat end"),
    FreeParameter("effects.bit_friction.radius", "radius at which the bit rubs", "mm", 1e-3, 1.0, 8.2,
                  "tip to rim"),
    FreeParameter("", PLAY, "", 1.0, 0.01, 0.95, "share of the hole's radius in which the bit moves freely"),
    FreeParameter("", SPRING, "N/m", 1.0, 5.0, 1e4, "rubber to steel"),
)  # fmt: skip
"""Numbers of a set, on a logarithmic scale."""
SLIP = (
    FreeParameter("", STATIC, "m/s", 1.0, 0.003, 0.5, "a film to five times the default of ADAMS, 0.1"),
    FreeParameter("", DYNAMIC, "", 1.0, 1.1, 50.0, "a fall at once to one over metres a second"),
)
"""Numbers of a set whose static and dynamic friction are joined by STEPs, after those of `FREE`."""
NUMBER = {parameter.name: k for k, parameter in enumerate((*FREE, *SLIP))}

STARTING = ("ramp of the load", "start of the load", "ramp of the rotation", "bow", "eccentricity")
"""Numbers that matter before the string touches the wall, and hardly after."""


class Choice(NamedTuple):
    """Reading of the bench that is one of a few; the first is that of `pa6_calibrated`."""

    name: str
    options: tuple[str, ...]
    chance: tuple[float, ...]
    """Chance of each option in a set drawn at random."""


CHOICES = (
    Choice("R = 90 mm", ("the radius of the hole", "its diameter"), (0.7, 0.3)),
    Choice("the load is counted", ("at the bit", "at the top"), (0.7, 0.3)),
    Choice("the hole is inclined by", ("0 degrees", "3 degrees", "10 degrees", "90 degrees"), (0.85, 0.05, 0.05, 0.05)),
    Choice("the bit", ("slides", "is guided", "has play and a spring"), (0.6, 0.1, 0.3)),
    Choice("the load rises", ("straight", "as a STEP"), (0.5, 0.5)),
    Choice("the rotation rises", ("straight", "as a STEP"), (0.5, 0.5)),
    Choice("friction falls with slip", ("to nothing", "to a share"), (0.6, 0.4)),
)
HOLE, LOAD_AT, INCLINATION, BIT, LOAD_SHAPE, ROTATION_SHAPE, LAW = range(len(CHOICES))
RADIUS = (0.090, 0.045)
INCLINED = tuple(math.radians(angle) for angle in (0.0, 3.0, 10.0, 90.0))
SHAPES = ("ramp", "step")
NO_TILT = 1e3
"""Stiffness against tilt of a bit with play [N m/rad]."""


class ParameterSet(NamedTuple):
    """Numbers and choices of the bench."""

    fractions: tuple[float, ...]
    """Of each number of `FREE`, and of `SLIP` if it has them, the way between its bounds, 0 to 1, rounded to 1e-4."""
    choices: tuple[int, ...]
    """Option of each of `CHOICES`."""

    @property
    def parameters(self) -> tuple[FreeParameter, ...]:
        """The numbers that it has."""
        return (*FREE, *SLIP)[: len(self.fractions)]

    @property
    def joined(self) -> bool:
        """True for static and dynamic friction joined by STEPs as in ADAMS; the choice of `LAW` is then ignored."""
        return len(self.fractions) > len(FREE)

    def number(self, name: str) -> float:
        """A number [SI] by its name."""
        k = NUMBER[name]
        return self.parameters[k].value(self.fractions[k])

    def keys(self, case: Case | None = None) -> dict[str, Any]:
        """Values by key of the bench in its lateral form; with load and speed of a case, if one is given."""
        option, radius = self.choices, RADIUS[self.choices[HOLE]]
        bit = ("sliding", "guided", "stabilised")[option[BIT]]
        left = self.number(FRACTION_LEFT) if option[LAW] or self.joined else 0.0
        values: dict[str, Any] = {
            place: parameter.value(fraction)
            for parameter, fraction in zip(self.parameters, self.fractions, strict=True)
            for place in (parameter.place, *parameter.also)
            if place
        } | {
            "hole.radius": radius,
            "hole.inclination": INCLINED[option[INCLINATION]],
            "rig.weight_on_bit.at": ("bit", "top")[option[LOAD_AT]],
            "rig.weight_on_bit.shape": SHAPES[option[LOAD_SHAPE]],
            "rig.rotation.shape": SHAPES[option[ROTATION_SHAPE]],
            "string.bit_end": bit,
            "effects.wall_friction.sliding": left * self.number("friction at the wall"),
        }
        if bit != "sliding":
            values["effects.bit_friction.coefficient"] = 0.0
        if bit == "stabilised":
            block = "effects.bit_stabiliser."
            values[block + "gauge"] = 2.0 * radius * (1.0 - self.number(PLAY))
            values |= {block + "stiffness": self.number(SPRING), block + "tilt_stiffness": NO_TILT}
        if self.joined:
            law = "effects.wall_friction."
            values |= {law + "decay": 0.0, law + "static_speed": self.number(STATIC)}
            values[law + "dynamic_speed"] = self.number(STATIC) * self.number(DYNAMIC)
        return values if case is None else values | case.keys()

    def described(self) -> dict[str, str]:
        """Numbers with their units, and choices, in words; numbers that the choices do not use are left out."""
        unused = {"fall of friction with slip"} if self.joined else {FRACTION_LEFT} if self.choices[LAW] == 0 else set()
        unused |= {PLAY, SPRING} if self.choices[BIT] != 2 else set()
        unused |= {"friction at the bit", "radius at which the bit rubs"} if self.choices[BIT] != 0 else set()
        return {
            parameter.name: f"{parameter.value(fraction) / parameter.scale:.3g} {parameter.unit}".rstrip()
            for parameter, fraction in zip(self.parameters, self.fractions, strict=True)
            if parameter.name not in unused
        } | {choice.name: choice.options[option] for choice, option in zip(CHOICES, self.choices, strict=True)}


def parameter_set(fractions: Array, choices: Sequence[int]) -> ParameterSet:
    """The set with these fractions, rounded and within the bounds."""
    return ParameterSet(tuple(round(float(x), 4) for x in np.clip(fractions, 0.0, 1.0)), tuple(choices))


def random_set(random: np.random.Generator, *, joined: bool = False) -> ParameterSet:
    """A set drawn at random."""
    choices = [int(random.choice(len(choice.options), p=choice.chance)) for choice in CHOICES]
    return parameter_set(random.random(len(FREE) + joined * len(SLIP)), choices)


def mutated(random: np.random.Generator, one: ParameterSet, other: ParameterSet) -> ParameterSet:
    """A neighbour of a set: some numbers moved or taken from another set, now and then another choice."""
    fractions = np.array(one.fractions)
    part = random.choice(3)  # of the start, of the whirl, or of both
    free = np.array([part == 2 or (parameter.name in STARTING) == (part == 0) for parameter in one.parameters])
    moved = free & (random.random(fractions.size) < random.choice((0.2, 0.5, 1.0)))
    fractions += moved * random.choice((0.01, 0.04, 0.15)) * random.standard_normal(fractions.size)
    if random.random() < 0.3:
        fractions = np.where(random.random(fractions.size) < 0.3, other.fractions, fractions)
    choices = list(one.choices)
    for k, choice in enumerate(CHOICES):
        if random.random() < 0.05:
            choices[k] = int(random.choice(len(choice.options), p=choice.chance))
    return parameter_set(fractions, choices)


def set_of(scene: Scene, *, joined: bool = False) -> ParameterSet:
    """The set nearest to a scene; joined friction is at the speeds of ADAMS, 0.1 and 1 m/s.

    Raises:
        SceneError: The scene lacks an effect whose numbers are varied.
    """
    fractions = [0.5] * len(FREE)
    for k, parameter in enumerate(FREE):
        if parameter.place:
            part = parameter.place.rpartition(".")[0]
            if value_at(scene, part) is None:
                raise SceneError(f"{scene.name}: expected `{part}`, whose {parameter.name} is varied, found none")
            found = float(value_at(scene, parameter.place))
            fractions[k] = parameter.fraction(found) if found > 0.0 else 0.0
    if joined:
        fractions += [parameter.fraction(value) for parameter, value in zip(SLIP, (0.1, 10.0), strict=True)]
    choices, rig = [0] * len(CHOICES), scene.rig
    choices[HOLE] = int(scene.hole.radius < 0.06)
    choices[LOAD_AT] = int(rig.weight_on_bit.at == "top")
    choices[INCLINATION] = int(np.argmin(np.abs(np.array(INCLINED) - scene.hole.inclination)))
    choices[BIT] = int(scene.string.bit_end == "guided")
    choices[LOAD_SHAPE] = int(rig.weight_on_bit.shape == "step")
    choices[ROTATION_SHAPE] = int(rig.rotation.shape == "step")
    return parameter_set(np.array(fractions), choices)
