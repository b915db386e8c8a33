# SPDX-License-Identifier: Apache-2.0
"""A scene as text, and ways to change one thing in it."""

import re
from collections.abc import Callable, Mapping

import pytest

from drill_twin.core.errors import SceneError
from drill_twin.scene import Scene, parse_scene

GOOD = """\
name: small
string:
  sections:
    - length: 5 m
      outer_diameter: 16.5 mm
      youngs_modulus: 2.3 GPa
      poisson_ratio: 0.394
      density: 1.10 g/cm^3
  marks:
    - {name: low, distance_from_bit: 0.5 m, on: wall}
    - {name: high, distance_from_bit: 4.4 m, on: centre}
  bit_end: sliding
hole:
  radius: 90 mm
rig:
  weight_on_bit: {shape: step, value: 40 N, duration: 15 s}
  rotation: {shape: ramp, value: 2 rev/s, duration: 0.5 s}
  duration: 30 s
effects:
  gravity: {}
  stretch: {}
  torsion: {}
  bow: {amplitude: 2 mm}
  eccentricity: {offset: 0.1 mm}
  wall: {stiffness: 1e7 N/m^2.5}
  wall_friction: {coefficient: 0.1}
numerics:
  frame_rate: 100 Hz
"""

Build = Callable[..., Scene]
Refusal = Callable[..., str]


@pytest.fixture(scope="session")
def good() -> str:
    return GOOD


@pytest.fixture(scope="session")
def changed() -> Build:
    """The good scene with one text replaced."""

    def build(old: str = "", new: str = "", overrides: Mapping[str, str] | None = None) -> Scene:
        assert old in GOOD
        return parse_scene(GOOD.replace(old, new, 1), name="x.yaml", overrides=overrides)

    return build


@pytest.fixture(scope="session")
def refusal(changed: Build) -> Refusal:
    """The one line with which the changed scene is refused."""

    def message(old: str = "", new: str = "", overrides: Mapping[str, str] | None = None) -> str:
        with pytest.raises(SceneError) as caught:
            changed(old, new, overrides)
        text = str(caught.value)
        assert "\n" not in text
        assert "x.yaml" in text
        assert re.search(r"expected .*found ", text), text
        return text

    return message
