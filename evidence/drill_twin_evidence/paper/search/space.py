# SPDX-License-Identifier: Apache-2.0
"""Sets of numbers and of readings of the bench: everything that the paper leaves open."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.physics.effects.bit_stabiliser import BitStabiliser
from drill_twin.scene import Scene
from drill_twin_evidence.paper.calibration.parameters import FreeParameter
from drill_twin_evidence.paper.runs.cases import DAMPING, changed, value_at
from drill_twin_evidence.paper.runs.variants import VARIANTS

SHARE_LEFT = "share of friction left at high slip"
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
    FreeParameter("", SHARE_LEFT, "", 1.0, 0.02, 1.0, "static and dynamic friction"),
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


class Trial(NamedTuple):
    """Set of numbers and choices."""

    shares: tuple[float, ...]
    """Of each number of `FREE`, and of `SLIP` if it has them, the way between its bounds, 0 to 1, rounded to 1e-4."""
    choices: tuple[int, ...]
    """Option of each of `CHOICES`."""

    @property
    def parameters(self) -> tuple[FreeParameter, ...]:
        """The numbers that it has."""
        return (*FREE, *SLIP)[: len(self.shares)]

    @property
    def joined(self) -> bool:
        """True if static and dynamic friction are joined by STEPs, so that its choice of a law says nothing."""
        return len(self.shares) > len(FREE)

    def number(self, name: str) -> float:
        """A number [SI] by its name."""
        k = NUMBER[name]
        return self.parameters[k].value(self.shares[k])


def trial(shares: Array, choices: tuple[int, ...]) -> Trial:
    """The trial with these shares, rounded and within the bounds."""
    return Trial(tuple(round(float(min(max(share, 0.0), 1.0)), 4) for share in shares), tuple(choices))


def random_trial(random: np.random.Generator, *, joined: bool = False) -> Trial:
    """A set drawn at random."""
    choices = tuple(int(random.choice(len(choice.options), p=choice.chance)) for choice in CHOICES)
    return trial(random.random(len(FREE) + joined * len(SLIP)), choices)


def mutated(random: np.random.Generator, one: Trial, other: Trial) -> Trial:
    """A neighbour of a set: some numbers moved or taken from another set, now and then another choice."""
    shares = np.array(one.shares)
    part = random.choice(3)  # of the start, of the whirl, or of both
    free = np.array([part == 2 or (parameter.name in STARTING) == (part == 0) for parameter in one.parameters])
    moved = free & (random.random(shares.size) < random.choice((0.2, 0.5, 1.0)))
    shares += moved * random.choice((0.01, 0.04, 0.15)) * random.standard_normal(shares.size)
    if random.random() < 0.3:
        shares = np.where(random.random(shares.size) < 0.3, other.shares, shares)
    choices = list(one.choices)
    for k, choice in enumerate(CHOICES):
        if random.random() < 0.05:
            choices[k] = int(random.choice(len(choice.options), p=choice.chance))
    return trial(shares, tuple(choices))


def scene_of_trial(bench: Scene, one: Trial) -> Scene:
    """The bench in its lateral form, with the numbers and choices of a set."""
    values: dict[str, Any] = {
        place: parameter.value(share)
        for parameter, share in zip(one.parameters, one.shares, strict=True)
        for place in (parameter.place, *parameter.also)
        if place
    }
    option = one.choices
    bit = ("sliding", "guided", "stabilised")[option[BIT]]
    if bit != "sliding":
        values["effects.bit_friction.coefficient"] = 0.0
    radius = RADIUS[option[HOLE]]
    if bit == "stabilised":
        free = one.number(PLAY) * radius
        values["effects.bit_stabiliser"] = BitStabiliser(
            gauge=2.0 * (radius - free), stiffness=one.number(SPRING), tilt_stiffness=NO_TILT
        )
    left = one.number(SHARE_LEFT) if option[LAW] or one.joined else 0.0
    if one.joined:
        static = one.number(STATIC)
        values |= {
            "effects.wall_friction.decay": 0.0,
            "effects.wall_friction.static_speed": static,
            "effects.wall_friction.dynamic_speed": static * one.number(DYNAMIC),
        }
    values |= {
        "hole.radius": radius,
        "hole.inclination": INCLINED[option[INCLINATION]],
        "rig.weight_on_bit.at": ("bit", "top")[option[LOAD_AT]],
        "rig.weight_on_bit.shape": SHAPES[option[LOAD_SHAPE]],
        "rig.rotation.shape": SHAPES[option[ROTATION_SHAPE]],
        "string.bit_end": bit,
        "effects.wall_friction.sliding": left * one.number("friction at the wall"),
    }
    for place, value in values.items():
        bench = changed(bench, place, value)
    return bench


def trial_of_scene(scene: Scene) -> Trial:
    """The set nearest to a scene."""
    shares = np.full(len(FREE), 0.5)
    for k, parameter in enumerate(FREE):
        if parameter.place:
            found = float(value_at(scene, parameter.place))
            shares[k] = parameter.share(found) if found > 0.0 else 0.0
    rig = scene.rig
    choices = [0] * len(CHOICES)
    choices[HOLE] = int(scene.hole.radius < 0.06)
    choices[LOAD_AT] = int(rig.weight_on_bit.at == "top")
    choices[INCLINATION] = int(np.argmin(np.abs(np.array(INCLINED) - scene.hole.inclination)))
    choices[BIT] = int(scene.string.bit_end == "guided")
    choices[LOAD_SHAPE], choices[ROTATION_SHAPE] = (
        int(rig.weight_on_bit.shape == "step"),
        int(rig.rotation.shape == "step"),
    )
    return trial(shares, tuple(choices))


def known_trials(bench: Scene, *, joined: bool = False) -> list[Trial]:
    """The bench as calibrated, and its variants."""
    own = tuple(round(p.share(start), 4) for p, start in zip(SLIP, (0.1, 10.0), strict=True)) if joined else ()
    found = []
    for variant in VARIANTS:
        scene = bench
        for place, value in variant.changes.items():
            scene = changed(scene, place, value)
        one = trial_of_scene(scene)
        found.append(one._replace(shares=one.shares + own))
    return found
