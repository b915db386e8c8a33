# SPDX-License-Identifier: Apache-2.0
"""Random scenes: every number, section and choice of the schema drawn in the range in which it means something.

The schema takes what a machine of any size may have, 1 cm to 20 km of string and 1 N to 100 MN. Drawn independently,
such numbers would nearly all be nonsense (a kilometre of thread under a meganewton), so they are drawn as multiples of
what the string itself gives: its length, buckling load, first frequency, weight and clearance. `FIELDS` has an entry
for every quantity of every block, and a test holds it to that. Not drawn: surveyed holes and variants of friction
on the wall and at the bit (kernels of their own), records of rigs, a bit that cuts under a weight set at the top, a
bending moment at the bit, slopes at a held end.
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

from hypothesis import strategies as st

from drill_twin.physics.effects import EFFECTS


class Scale(NamedTuple):
    """What the numbers of a scene are drawn in multiples of."""

    length: float  # [m]
    radius: float  # of the string, the smallest outer one [m]
    widest: float  # the largest outer one [m]
    clearance: float  # [m]
    load: float  # buckling between clamps, of the softest section [N]
    frequency: float  # the first between clamps, of the softest section [rad/s]
    line_mass: float  # [kg/m]
    sections: int

    @property
    def hole(self) -> float:
        """Radius of the hole [m]."""
        return self.widest + self.clearance

    @property
    def mass(self) -> float:
        """Mass of the string [kg]."""
        return self.line_mass * self.length

    @property
    def inertia(self) -> float:
        """Its moment of inertia [kg m^2]."""
        return 0.5 * self.mass * self.radius**2


LARGEST = 2.0**24
BYTES = 900
"""Of the tape that a scene is read from: three for each number, and more than any scene needs."""


class Tape:
    """Random bytes, read as numbers; they shrink to zeros, which are the low ends of the ranges."""

    def __init__(self, content: bytes) -> None:
        self._content, self._at = content, 0

    def share(self) -> float:
        """The next number, from 0 up to 1."""
        self._at += 3
        return int.from_bytes(self._content[self._at - 3 : self._at], "big") / LARGEST

    def draw(self, strategy: "Strategy") -> Any:
        """Read one thing."""
        return strategy.read(self)


class Strategy(NamedTuple):
    """How one thing is read off a tape.

    Not strategies of hypothesis all the way down: it makes most of its examples by repeating parts of one that it has,
    and a hundred scenes were twenty. A tape is one draw.
    """

    read: Callable[[Tape], Any]

    def map(self, function: Callable[[Any], Any]) -> "Strategy":
        """What the function makes of it."""
        return Strategy(lambda tape: function(self.read(tape)))

    def __or__(self, other: "Strategy") -> "Strategy":
        """This or the other, as likely."""
        return Strategy(lambda tape: (self if tape.share() < 0.5 else other).read(tape))


Draw = Callable[[Strategy], Any]


def just(value: Any) -> Strategy:
    """Always the same."""
    return Strategy(lambda _: value)


def pick(*values: Any) -> Strategy:
    """One of them."""
    return Strategy(lambda tape: values[int(tape.share() * len(values))])


def whole(low: int, high: int) -> Strategy:
    """A whole number."""
    return Strategy(lambda tape: low + int(tape.share() * (high - low + 1)))


def between(low: float, high: float) -> Strategy:
    """Evenly over the range."""
    return Strategy(lambda tape: low + (high - low) * tape.share())


def log(low: float, high: float) -> Strategy:
    """Any order of magnitude as likely as any other."""
    return between(math.log(low), math.log(high)).map(lambda power: min(max(math.exp(power), low), high))


def or_zero(low: float, high: float) -> Strategy:
    """The same, and now and then nothing at all."""
    return Strategy(lambda tape: 0.0 if tape.share() < 0.1 else log(low, high).read(tape))


def block(**fields: Strategy) -> Strategy:
    """A mapping."""
    return Strategy(lambda tape: {key: field.read(tape) for key, field in fields.items()})


def several(number: int, one: Strategy) -> Strategy:
    """So many of them."""
    return Strategy(lambda tape: [one.read(tape) for _ in range(number)])


BUCKLES = {"guided": 1.0, "pinned": 0.51, "sliding": 0.25, "free": 0.0625, "stabilised": 0.51}
"""Euler's load for each end of the bit, in that between clamps."""
ANGLE = between(-math.tau, math.tau)
SEED = whole(0, 2**24)

FIELDS: dict[str, dict[str, Strategy | Callable[[Scale], Strategy]]] = {
    "gravity": {"magnitude": or_zero(0.1, 20.0)},
    "bow": {
        "amplitude": lambda s: or_zero(1e-3 * s.clearance, 0.3 * s.clearance),
        "shape": pick("half_wave", "uniform", "random"),
        "angle": ANGLE,
        "correlation_length": lambda s: log(0.3 * s.length, 3.0 * s.length),
        "seed": SEED,
    },
    "gyroscopic": {},
    "eccentricity": {
        "offset": lambda s: or_zero(1e-5 * s.radius, 0.4 * s.radius),
        "angle": ANGLE,
        "rms": lambda s: or_zero(1e-5 * s.radius, 0.4 * s.radius),
        "correlation_length": lambda s: log(0.1 * s.length, 3.0 * s.length),
        "seed": SEED,
        "sections": lambda s: just(None) | several(
            s.sections, block(offset=or_zero(1e-5 * s.radius, 0.4 * s.radius), angle=ANGLE),
        ),
    },
    "internal_damping": {
        key: (lambda s: or_zero(1e-5 / s.frequency, min(0.3 / s.frequency, 10.0)))
        for key in ("bending_time", "stretch_time", "torsion_time")
    },
    "drag": {
        "linear": lambda s: or_zero(1e-4 * s.line_mass * s.frequency, 3.0 * s.line_mass * s.frequency),
        "rotary": lambda s: or_zero(1e-6 * s.inertia * s.frequency / s.length, s.inertia * s.frequency / s.length),
    },
    "mud": {
        "density": log(1.0, 2700.0),
        "viscosity": log(1e-5, 1.0),
        "yield_point": or_zero(0.1, 30.0),
        "frequency": just(None),
        "index": between(0.3, 1.0),
        "inside": pick("mud", "air"),
    },
    "quadratic_drag": {"coefficient": or_zero(0.01, 2.0)},
    "added_mass": {"coefficient": or_zero(0.01, 3.0), "confined": pick(False, True)},
    "rotation_drag": {},
    "viscous_drag": {},
    "wall": {
        "stiffness": log(1e3, 1e12),
        "linear_stiffness": log(1e3, 1e10),
        "restitution": between(0.01, 1.0),
        "reference_speed": log(0.01, 10.0),
    },
    "wall_friction": {
        "coefficient": or_zero(1e-3, 2.0),
        "decay": or_zero(1e-3, 100.0),
        "accuracy": log(1e3, 1e8),
        "sliding": just(0.0),
        "exponent": just(None),
        "sign": just("root"),
        "static_speed": just(None),
        "dynamic_speed": just(None),
        "intervals": just(()),
    },
    "rock_floor": {
        "stiffness": lambda s: log(1e3 * s.load / s.length, min(1e7 * s.load / s.length, 1e12)),
        "damping": lambda s: or_zero(1e-3 * s.mass * s.frequency, 100.0 * s.mass * s.frequency),
        "lobes": just(3.0),
        "lobe_height": just(0.0),
    },
    "bit_cutting": {
        "threshold": or_zero(1e-6, 1e-3),
        "cutting": lambda s: log(1e-4 / s.load, 1e-1 / s.load) ,
        "advance": or_zero(1e-6, 1e-3),
        "digging": lambda s: or_zero(1e-2 * s.load, 10.0 * s.load),
        "rubbing": lambda s: or_zero(1e-4 * s.load * s.radius, 0.1 * s.load * s.radius),
        "regular_speed": log(0.1, 10.0),
        "rock_stiffness": just(None),
        "dispersion": or_zero(0.01, 0.5),
        "seed": SEED,
    },
    "bit_regenerative": {
        "radius": lambda s: log(0.3 * s.radius, 2.0 * s.radius),
        "blades": pick(1, 3, 4, 8),
        "specific_energy": lambda s: log(10.0 * s.load / s.radius**2, min(1e5 * s.load / s.radius**2, 1e11)),
        "thrust": between(0.1, 2.0),
        "wear": lambda s: or_zero(1e-4 * s.radius, 0.1 * s.radius),
        "contact_strength": lambda s: log(0.1 * s.load / s.radius**2, min(10.0 * s.load / s.radius**2, 1e11)),
        "friction": or_zero(1e-3, 2.0),
        "spread": between(0.5, 2.0),
        "regeneration": pick(True, False),
        "contact_depth": just(1e-5),
        "settling": just(1e-6),
        "creep": log(1e-5, 1e-2),
    },
    "bit_friction": {
        "coefficient": or_zero(1e-3, 2.0),
        "radius": lambda s: log(0.1 * s.radius, s.radius),
    },
    "bit_torque_tanh": {
        "arm": lambda s: or_zero(1e-3 * s.radius, s.radius),
        "rise": log(0.1, 100.0),
        "excess": or_zero(0.1, 10.0),
        "fall": log(0.1, 100.0),
    },
    "bit_torque_stribeck": {
        "bit": just(None),
        "radius": lambda s: log(0.1 * s.radius, s.radius),
        "sliding": or_zero(0.01, 1.0),
        "sticking": between(1.0, 2.0),
        "decay": or_zero(0.01, 10.0),
        "exponent": just(None),
        "specific_energy": log(1e6, 1e10),
        "creep": log(1e-6, 1e-2),
    },
    "bit_mass": {
        "mass": lambda s: or_zero(1e-3 * s.mass, min(10.0 * s.mass, 1e6)),
        "inertia": lambda s: or_zero(1e-3 * s.inertia, 100.0 * s.inertia),
        "damping": lambda s: or_zero(1e-3 * s.inertia * s.frequency, 10.0 * s.inertia * s.frequency),
    },
    "bit_stabiliser": {
        "gauge": lambda s: between(1.0, 2.0 - 1e-3).map(lambda share: share * s.hole),
        "stiffness": lambda s: log(10.0 * s.load / s.length, min(1e7 * s.load / s.length, 1e12)),
        "damping": lambda s: or_zero(1e-3 * s.mass * s.frequency, 10.0 * s.mass * s.frequency),
        "friction": or_zero(1e-3, 2.0),
        "tilt_stiffness": lambda s: or_zero(1e-3 * s.load * s.length, 1e3 * s.load * s.length),
    },
    "bit_side_force": {
        "force": lambda s: between(-0.5 * s.load * s.clearance / s.length, 0.5 * s.load * s.clearance / s.length),
        "moment": just(0.0),
        "angle": ANGLE,
        "turns": pick("with_hole", "with_bit"),
        "ramp": lambda s: or_zero(0.1 / s.frequency, 10.0 / s.frequency),
    },
    "lateral_kick": {
        "velocity": lambda s: between(-s.clearance * s.frequency, s.clearance * s.frequency),
        "offset": lambda s: just(0.0) | between(-0.9 * s.clearance, 0.9 * s.clearance),
        "shape": just("hump"),
    },
    "random_force": {
        "rms": lambda s: or_zero(1e-3 * s.line_mass, 100.0 * s.line_mass),
        "correlation_time": lambda s: log(1e-2 / s.frequency, 10.0 / s.frequency),
        "correlation_length": lambda s: log(0.1 * s.length, 3.0 * s.length),
        "seed": SEED,
    },
    "top_shake": {
        "amplitude": lambda s: or_zero(1e-4 * s.clearance, 0.3 * s.clearance),
        "frequency": lambda s: between(0.0, min(3.0 * s.frequency / math.tau, 1000.0)),
        "direction": ANGLE,
        "bandwidth": lambda s: or_zero(1e-3 * s.frequency, min(0.1 * s.frequency, 1000.0)),
        "seed": SEED,
    },
}  # fmt: skip
"""How each field of each effect is drawn."""


def sections(draw: Draw) -> list[dict[str, float]]:
    """One to three sections of one slender string."""
    diameter = draw(log(5e-3, 0.3))
    length = diameter * draw(log(60.0, 1000.0))
    number = draw(whole(1, 3))
    found = []
    for _ in range(number):
        outer = diameter * draw(between(1.0, 3.0))
        found.append({
            "length": length / number * draw(between(0.5, 1.5)),
            "outer_diameter": outer,
            "inner_diameter": outer * draw(just(0.0) | between(0.1, 0.9)),
            "youngs_modulus": draw(log(1e9, 2.2e11)),
            "poisson_ratio": draw(between(0.0, 0.49)),
            "density": draw(log(900.0, 9000.0)),
            "blade_diameter": outer * draw(just(1.0) | between(1.0, 1.3)),
        })  # fmt: skip
    return found


def scale_of(parts: list[dict[str, float]], room: float) -> Scale:
    """The scales of a string; `room` is the clearance over its largest radius."""
    length = sum(part["length"] for part in parts)
    softest, radius, line_mass = math.inf, math.inf, 0.0
    for part in parts:
        outer, inner = part["outer_diameter"], part["inner_diameter"]
        softest = min(softest, part["youngs_modulus"] * math.pi / 64.0 * (outer**4 - inner**4))
        line_mass = max(line_mass, part["density"] * math.pi / 4.0 * (outer**2 - inner**2))
        radius = min(radius, 0.5 * outer)
    widest = 0.5 * max(part["blade_diameter"] for part in parts)
    frequency = 22.373 / length**2 * math.sqrt(softest / line_mass)
    load = 4.0 * math.pi**2 * softest / length**2
    return Scale(length, radius, widest, room * widest, load, frequency, line_mass, len(parts))


def effects(draw: Draw, names: frozenset[str], s: Scale) -> dict[str, dict[str, Any]]:
    """The blocks of a set of effects."""
    found = {
        key: {name: draw(field(s) if callable(field) else field) for name, field in FIELDS.get(key, {}).items()}
        for key in sorted(names)
    }
    if "bow" in found and found["bow"]["shape"] != "random":
        del found["bow"]["correlation_length"], found["bow"]["seed"]
    if "eccentricity" in found:
        block = found["eccentricity"]
        for key in ("offset", "angle") if block["sections"] else ("sections",):
            del block[key]
        if block["rms"] == 0.0:
            del block["correlation_length"]
        else:
            for part in block.get("sections", ()):
                part["offset"] = min(part["offset"], s.radius - 2.0 * block["rms"])
    if "wall" in found:
        del found["wall"][draw(pick("stiffness", "linear_stiffness"))]
    return found


def top_drives(s: Scale) -> Strategy:
    """A prescribed speed, a controller, or one that swallows torsional waves."""
    inertia, gain = s.inertia, s.inertia * s.frequency
    own = {"inertia": or_zero(0.1 * inertia, min(1e3 * inertia, 1e6)), "damping": or_zero(0.01 * gain, 10.0 * gain)}
    gains = {"proportional_gain": log(gain, 1e4 * gain), "integral_gain": or_zero(gain, 100.0 * gain * s.frequency)}
    limit = {"torque_limit": just(None) | log(0.1 * s.load * s.radius, 10.0 * s.load * s.radius)}
    return (
        just({})
        | block(model=just("speed_controller"), **own, **gains, **limit)
        | block(model=just("impedance"), reflection=between(-0.9, 0.9), **own, **limit)
    )


def scenes(names: frozenset[str]) -> st.SearchStrategy[dict[str, Any]]:
    """Scenes with exactly these effects, as plain SI numbers."""
    return st.binary(min_size=BYTES, max_size=BYTES).map(lambda content: scene(Tape(content).draw, names))


def scene(draw: Draw, names: frozenset[str]) -> dict[str, Any]:
    """The scene of a tape."""
    parts = sections(draw)
    s = scale_of(parts, draw(log(0.02, 6.0)))
    washed_out = sorted(draw(several(2, between(0.0, s.length))))
    wider = just([]) | between(1.0, 1.5).map(
        lambda share: [{"top": washed_out[0], "bottom": washed_out[1] + 0.01, "radius": share * s.hole}]
    )
    frame = min(max(s.frequency, 1.0), 2000.0)  # six frames to the period of the first mode
    turn = between(-3.0 * s.frequency, 3.0 * s.frequency)
    top = math.tau * 50.0
    speeds = [max(-top, min(top, draw(turn))) for _ in range(2)]
    at = "top" if names & {"rock_floor", "bit_regenerative"} else "bit"
    change = block(
        shape=pick("step", "ramp"), start=between(0.0, 5.0 / frame), duration=or_zero(0.1 / frame, 10.0 / frame)
    )
    ends = ["stabilised"] if "bit_stabiliser" in names else ["sliding", "free"]
    if not {"bit_stabiliser", "bit_friction", "bit_side_force"} & names:
        ends += ["guided", "pinned"]
    end = draw(pick(*ends))
    load = between(-2.0 * BUCKLES[end] * s.load, 5.0 * BUCKLES[end] * s.load)
    return {
        "name": "random",
        "string": {"sections": parts, "bit_end": end,
                   "marks": [{"name": "m", "distance_from_bit": draw(between(0.0, s.length))}]},
        "hole": {"radius": s.hole, "inclination": draw(just(0.0) | between(0.0, math.pi)),
                 "intervals": draw(wider)},
        "rig": {
            "weight_on_bit": {**draw(change), "initial": draw(load), "value": draw(load), "at": at},
            "rotation": {**draw(change), "initial": speeds[0], "value": speeds[1]},
            "top_drive": draw(top_drives(s)) if "torsion" in names else {},
            "duration": 1.0,
        },
        "effects": effects(draw, names, s),
        "numerics": {"elements": draw(whole(4, 24)), "frame_rate": frame, "seed": draw(SEED)},
    }  # fmt: skip


def mirrored(data: dict[str, Any]) -> dict[str, Any] | None:
    """The scene seen in a mirror, y to -y: turning the other way; None where the schema cannot say it.

    Cutters face one way, whatever the mirror shows.
    """
    blocks = {key: dict(block) for key, block in data["effects"].items()}
    bow, lopsided = blocks.get("bow", {}), blocks.get("eccentricity", {})
    if {"random_force", "bit_cutting"} & set(blocks) or bow.get("shape") == "random" or lopsided.get("rms"):
        return None
    for key, name in (
        ("bow", "angle"),
        ("eccentricity", "angle"),
        ("bit_side_force", "angle"),
        ("top_shake", "direction"),
    ):
        if name in blocks.get(key, {}):
            blocks[key][name] = -blocks[key][name]
    if lopsided.get("sections"):
        lopsided["sections"] = [{**part, "angle": -part["angle"]} for part in lopsided["sections"]]
    turn = data["rig"]["rotation"]
    rig = {**data["rig"], "rotation": {**turn, "initial": -turn["initial"], "value": -turn["value"]}}
    return {**data, "effects": blocks, "rig": rig}


def quantities(key: str) -> set[str]:
    """Fields of an effect's block."""
    return set(EFFECTS[key].model_fields)
