# SPDX-License-Identifier: Apache-2.0
"""Notes on a scene that can be simulated but not as its author may expect: mesh, drag, idle friction intervals."""

import math
from collections.abc import Iterator

from drill_twin.discretisation.discretise import sections_of
from drill_twin.discretisation.grading import LONG, PER_WAVE
from drill_twin.discretisation.resolution import ELEMENTS_PER_PITCH, most_elements, wanted_elements
from drill_twin.model.mesh import tube_constants
from drill_twin.scene import Scene
from drill_twin.scene.blocks.numerics import MOST_ELEMENTS
from drill_twin.schedule import extremes

LARGEST_SHEAR = 4e-4
"""Shear strain at the top from rotary drag beyond which a note is given [-]: a tenth of that at which steel yields."""


def notes_on(scene: Scene) -> list[str]:
    """Sentences on the resolution, the rotary drag and the friction intervals of a scene.

    Raises:
        TableError: A record that cannot be used.
    """
    return [*_coarse_mesh(scene), *_rotary_drag(scene), *_friction_below_the_string(scene)]


def frequency_error(elements: float) -> float:
    """Relative error of the frequency of a bending wave with this many cubic elements a wave length, (k h)^4 / 1440."""
    return (math.tau / elements) ** 4 / 1440.0


def _coarse_mesh(scene: Scene) -> Iterator[str]:
    if scene.numerics.elements != "auto" or scene.numerics.accuracy is not None:
        return
    wanted, most = wanted_elements(scene, max(extremes(scene).weight_on_bit, 1.0)), most_elements(scene)
    if wanted > most:
        per_wave, of = (
            (PER_WAVE, "a bending wave at the frequency of rotation, locally")
            if scene.length >= LONG
            else (ELEMENTS_PER_PITCH, "a pitch of the buckling helix")
        )
        each = per_wave * most / wanted
        yield (
            f"`numerics.elements: auto` takes {most} elements, its most, where its rule ({per_wave} {of}) "
            f"asks for {wanted}: with {each:.1f}, frequencies of such waves are about "
            f"{100.0 * frequency_error(each):.2g} % too high in place of "
            f"{100.0 * frequency_error(per_wave):.2g} %; for more write "
            f"`numerics.elements: {min(wanted, MOST_ELEMENTS)}`"
        )


def _rotary_drag(scene: Scene) -> Iterator[str]:
    drag = getattr(scene.effects, "drag", None)
    if drag is None or drag.rotary == 0.0:
        return
    speed, tubes = extremes(scene).rotation, sections_of(scene)
    torque = drag.rotary * scene.length * speed
    stiffness = tube_constants(tubes[-1])[2]
    shear = torque / stiffness * 0.5 * tubes[-1].outer_diameter
    if shear > LARGEST_SHEAR:
        yield (
            f"`effects.drag.rotary` takes {torque:.3g} N m from the top drive at {speed * 30.0 / math.pi:.3g} rpm over "
            f"{scene.length:.6g} m: a shear strain of {100.0 * shear:.2g} % at the top, more than a tenth of what "
            "steel pipe carries; the couple of mud is far smaller (`mud` with `rotation_drag`)"
        )


def _friction_below_the_string(scene: Scene) -> Iterator[str]:
    friction = getattr(scene.effects, "wall_friction", None)
    for index, interval in enumerate(friction.intervals if friction else ()):
        if interval.top >= scene.length:
            yield (
                f"`effects.wall_friction.intervals[{index}]` begins at {interval.top:.6g} m, below the bit at "
                f"{scene.length:.6g} m: no part of the string is in it"
            )
