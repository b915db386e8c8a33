# SPDX-License-Identifier: Apache-2.0
"""Drawn rotors: modes by drill_twin against the finite elements of `beams`, and against the band that it prints.

    python -m drill_twin_evidence.rotors.drawn 200        # a line for each rotor; exit code 1 if one is outside

Drawn: one to three shafts, up to three discs (some as thin as a coin), up to three supports (some stiff as 1e12 N/m,
some with two stiffnesses), ends, speed, gravity along the shaft.
"""

from __future__ import annotations

import math
import sys
from typing import Any, NamedTuple

import numpy as np

from drill_twin.api import modes
from drill_twin.scene import Scene
from drill_twin_evidence.rotors.beams import Bearing, Rotor, Shaft, Wheel, eigenvalues, system

COMPARED, SHARE, LEAST = 8, 5e-3, 3e-5
"""Lowest lateral modes compared, the share of a frequency that is allowed where the band is smaller, and the share of
the highest frequency compared below which the dense solver of `beams` has no digits."""
FINE = 24
"""Elements of a shaft in the comparison."""
FASTEST = 620.0
"""Fastest rotation of a scene [rad/s], a little less."""
ENDS = {"pinned": "place", "free": "", "guided": "place slope", "sliding": "slope"}
TOPS = {"clamped": "place slope", "hinged": "place", "free": ""}


class Outcome(NamedTuple):
    """Modes of a rotor: by drill_twin, band, by `beams` [Hz], shape (k,) each."""

    found: np.ndarray
    band: np.ndarray
    true: np.ndarray

    @property
    def worst(self) -> float:
        """Largest error over what is allowed; a rotor on no springs has frequencies of 0, which have no share."""
        least = np.maximum(SHARE * self.true, LEAST * self.true.max())
        return float(np.max(np.abs(self.found - self.true) / np.maximum(self.band, least)))


def drawn(number: int) -> tuple[dict[str, Any], Rotor, float]:
    """Scene, rotor and speed [rad/s] of a number."""
    random = np.random.default_rng(number)
    diameter = float(np.exp(random.uniform(math.log(5e-3), math.log(0.2))))
    shafts, sections, start = [], [], 0.0
    for _ in range(random.integers(1, 4)):
        own, length = diameter * random.uniform(0.7, 1.4), diameter * random.uniform(15.0, 60.0)
        bore = own * random.choice([0.0, 0.6])
        shafts.append(Shaft(length, own, bore, 206e9, 7850.0, FINE))
        sections.append({"length": length, "outer_diameter": own, "inner_diameter": bore, "youngs_modulus": 206e9,
                         "density": 7850.0})  # fmt: skip
        start += length
    wheels, discs, bearings, supports = [], [], [], []
    for k in range(random.integers(0, 4)):
        outer, width = diameter * random.uniform(3.0, 12.0), diameter * random.uniform(0.1, 2.0)
        mass = 7850.0 * math.pi / 4.0 * outer**2 * width
        polar, diametral = mass * outer**2 / 8.0, mass * (outer**2 / 16.0 + width**2 / 12.0)
        place = float(random.choice([0.0, 1.0, *random.uniform(0.05, 0.95, 6)])) * start
        wheels.append(Wheel(place, mass, polar, diametral))
        discs.append({"name": f"d{k}", "distance_from_bit": place, "mass": mass, "polar_inertia": polar,
                      "diametral_inertia": diametral})  # fmt: skip
    scale = 206e9 * math.pi / 64.0 * diameter**4 / start**3
    bit, top = (str(random.choice([*kind])) for kind in (ENDS, TOPS))
    places = random.uniform(0.05, 0.95, 3) * start
    for k in range(2 if top == "free" else random.integers(0, 3)):
        stiff = scale * 10.0 ** random.uniform(0.0, 3.0) if random.random() < 0.8 else 1e12
        other = stiff if random.random() < 0.6 else stiff * random.uniform(0.4, 1.0)
        tilt = scale * start**2 * random.choice([0.0, 0.3])
        damping = 0.02 * math.sqrt(scale * 7850.0 * diameter**2 * start)
        bearings.append(Bearing(places[k], np.diag([stiff, other]), damping * np.eye(2), tilt))
        supports.append({"name": f"s{k}", "distance_from_bit": places[k], "stiffness": stiff, "stiffness_y": other,
                         "damping": damping, "tilt_stiffness": tilt})  # fmt: skip
    gravity = float(random.choice([0.0, 9.81]))
    first = math.pi**2 * math.sqrt(scale * start**3 / (7850.0 * math.pi / 4.0 * diameter**2 * start**4))
    speed = min(first * random.uniform(0.0, 3.0), FASTEST)
    rotor = Rotor(tuple(shafts), tuple(wheels), tuple(bearings), ENDS[bit], TOPS[top], gravity)
    scene = {
        "name": f"rotor_{number}",
        "string": {"sections": sections, "discs": discs, "supports": supports, "bit_end": bit, "top_end": top},
        "hole": {"radius": min(100.0 * diameter, 10.0)},
        "rig": {
            "weight_on_bit": {"shape": "constant", "value": 0.0},
            "rotation": {"shape": "constant", "value": speed},
            "duration": 1.0,
        },
        "effects": {"gyroscopic": {}, **({"gravity": {"magnitude": gravity}} if gravity else {})},
    }
    return scene, rotor, speed


def outcome(number: int) -> Outcome:
    """Compare the modes of a drawn rotor."""
    raw, rotor, speed = drawn(number)
    table = modes(Scene.model_validate(raw))
    true = eigenvalues(system(rotor), speed, COMPARED + 4)
    lateral = [mode for mode in table.of("lateral") if abs(mode.frequency) > 0.0]
    ours = sorted(lateral, key=lambda mode: abs(mode.frequency))[:COMPARED]
    frequency = np.array([abs(mode.frequency) for mode in ours])
    band = np.array([abs(mode.change.imag) / math.tau for mode in ours])
    return Outcome(frequency, band, np.sort(true.imag / math.tau)[: frequency.size])


def main(count: int) -> int:
    """Print the worst mode of each rotor; 1 if one is outside."""
    outside = 0
    for number in range(count):
        own = outcome(number)
        outside += own.worst > 1.0
        share = float(np.max(np.abs(own.found - own.true) / np.maximum(own.true, LEAST * own.true.max())))
        print(f"{number:4}  error over allowed {own.worst:8.4f}, error {share:9.2e} of the frequency", flush=True)
    print(f"{outside} of {count} rotors outside band and {SHARE:.1%}")
    return int(outside > 0)


if __name__ == "__main__":
    sys.exit(main(int(sys.argv[1]) if len(sys.argv) > 1 else 200))
