# SPDX-License-Identifier: Apache-2.0
"""Notes on a scene that can be simulated but not as its author may expect: mesh, drag, friction intervals, rolling."""

import math
from collections.abc import Iterator

import numpy as np

from drill_twin.dynamics.discretisation.discretise import (
    sections_of,
)
from drill_twin.dynamics.discretisation.joint import buckled_up_to, joint_of
from drill_twin.dynamics.discretisation.resolution import (
    IN_TORSION,
    LONG,
    PER_PITCH,
    PER_WAVE,
    most_elements,
    resolution_of,
    step_of_motion,
    stick_slip_step,
    wanted_elements,
)
from drill_twin.physics.model import tube_constants
from drill_twin.scene import Scene
from drill_twin.scene.blocks.numerics import MOST_ELEMENTS
from drill_twin.scene.check import needs_lateral
from drill_twin.scene.set_points import extremes

LARGEST_SHEAR = 4e-4
"""Shear strain at the top from rotary drag beyond which a note is given [-]: a tenth of that at which steel yields."""

TOLD = 1.5
"""Processor time of stick-slip, over the time that the rest of the motion takes, from which a note tells it; chosen."""
FRAMES_IN_ORBIT, STEPS_IN_ORBIT = 2.5, 20.0
"""Frames in an orbit that whirl needs to be seen (`whirl.criteria.NEEDED_IN_ORBIT`), and time steps in which the
midpoint rule turns it by 0.8 % too little."""
LEAST_GYROSCOPIC = 5e-3
"""Change of a lateral frequency from which a note is given; chosen."""
THICKER = 2.0
"""Diameter over a neighbour's from which a section shorter than its diameter is a disc; chosen."""


ON_THE_JOINT = ("lateral motion from ", "`numerics.lateral_from: auto` is 0 m")
"""Beginnings of the notes on the part of a string that moves laterally, which warn of nothing."""


def notes_on(scene: Scene) -> list[str]:
    """Sentences on the resolution, the rotary drag, the friction intervals and the rolling of a scene.

    Raises:
        TableError: A record that cannot be used.
    """
    return [
        *_joint(scene),
        *_left_hand(scene),
        *_coarse_mesh(scene),
        *_rotary_drag(scene),
        *_friction_below_the_string(scene),
        *_rolling(scene),
        *_stick_slip(scene),
        *notes_on_rotors(scene),
    ]


def notes_on_rotors(scene: Scene) -> list[str]:
    """Sentences on sections that are discs, and on gyroscopic moments that a scene leaves out."""
    return [*_short_thick(scene), *_gyroscopic(scene)]


def _joint(scene: Scene) -> Iterator[str]:
    joint, effects, text = joint_of(scene), scene.effects, scene.unit_system.text
    if joint is None:
        if scene.numerics.lateral_from == "auto":
            why = ", ".join(needs_lateral(scene))
            yield f"{ON_THE_JOINT[1]}: the whole string moves laterally{why and ', for ' + why}"
        return
    above: dict[str, list[str]] = {
        "marks on the axis": [mark.name for mark in scene.string.marks if mark.distance_from_bit > joint],
        "supports that hold nothing": [held.name for held in scene.string.supports if held.distance_from_bit > joint],
        "fatigue of the hole's bending only": [
            section.name
            for section in (effects.fatigue.sections if effects.fatigue else ())
            if section.distance(scene.length) > joint
        ],
    }
    yield (
        f"{ON_THE_JOINT[0]}{text(scene.length - joint, 'length')} down (`numerics.lateral_from`); above, the string "
        + "; ".join(["follows the hole", *(f"{what}: {', '.join(names)}" for what, names in above.items() if names)])
    )
    if (buckled := buckled_up_to(scene)) > joint:
        yield (
            f"pipe up to {text(buckled, 'length')} from the bit may buckle, but has no lateral motion there: expected "
            f"numerics.lateral_from at most {text(max(scene.length - buckled, 0.0), 'length')}"
        )


def _left_hand(scene: Scene) -> Iterator[str]:
    if min(scene.rig.rotation.value, scene.rig.rotation.initial) < 0.0 and (why := scene.string.backs_off):
        yield f"`rig.rotation` is below 0, to the left: {why}"


def frequency_error(elements: float) -> float:
    """Relative error of the frequency of a bending wave with this many cubic elements a wave length, (k h)^4 / 1440."""
    return (math.tau / elements) ** 4 / 1440.0


def _coarse_mesh(scene: Scene) -> Iterator[str]:
    if scene.numerics.elements != "auto" or scene.numerics.accuracy is not None:
        return
    wanted, most = wanted_elements(scene), most_elements(scene)
    if wanted > most:
        per_wave, of = (
            (PER_WAVE, "a bending wave at the frequency of rotation, locally")
            if scene.length >= LONG
            else (PER_PITCH, "a pitch of the buckling helix")
        )
        each = per_wave * most / wanted
        yield (
            f"`numerics.elements: auto` takes {most} elements, its most, where its rule ({per_wave} {of}) "
            f"asks for {wanted}: with {each:.1f}, frequencies of such waves are about "
            f"{100.0 * frequency_error(each):.2g} % too high in place of "
            f"{100.0 * frequency_error(per_wave):.2g} %; for more write "
            f"`numerics.elements: {min(wanted, MOST_ELEMENTS)}`"
        )


def _stick_slip(scene: Scene) -> Iterator[str]:
    wanted = stick_slip_step(scene)
    if scene.numerics.step != "auto" or scene.numerics.accuracy is not None or step_of_motion(scene) < TOLD * wanted:
        return
    step = resolution_of(scene)[1]
    needs = "is taken" if step <= wanted else f"is not taken: the time step is {1e3 * step:.2g} ms"
    yield (
        f"period and peak speed of stick-slip within 1 % need a time step of {1e3 * wanted:.2g} ms, a {IN_TORSION}th "
        f"of the period of torsion, and {step_of_motion(scene) / wanted:.2g} times the processor time of other motion; "
        f"this step {needs}"
    )


def _rotary_drag(scene: Scene) -> Iterator[str]:
    drag = getattr(scene.effects, "drag", None)
    if drag is None or drag.rotary == 0.0:
        return
    speed, tubes, units = extremes(scene).rotation, sections_of(scene), scene.unit_system
    torque = drag.rotary * scene.length * speed
    stiffness = tube_constants(tubes[-1])[2]
    shear = torque / stiffness * 0.5 * tubes[-1].outer_diameter
    if shear > LARGEST_SHEAR:
        yield (
            f"`effects.drag.rotary` takes {units.text(torque, 'torque')} from the top drive at "
            f"{speed * 30.0 / math.pi:.3g} rpm over {units.text(scene.length, 'length')}: a shear strain of "
            f"{100.0 * shear:.2g} % at the top, more than a tenth of what steel pipe carries; "
            "the couple of mud is far smaller (`mud` with `rotation_drag`)"
        )


def _friction_below_the_string(scene: Scene) -> Iterator[str]:
    friction, units = getattr(scene.effects, "wall_friction", None), scene.unit_system
    for index, interval in enumerate(friction.intervals if friction else ()):
        if interval.top >= scene.length:
            yield (
                f"`effects.wall_friction.intervals[{index}]` begins at {units.text(interval.top, 'length')}, below the "
                f"bit at {units.text(scene.length, 'length')}: no part of the string is in it"
            )


def _rolling(scene: Scene) -> Iterator[str]:
    """Rolling along the wall, at minus radius over clearance times the rotation, that frames or steps cannot show.

    Nothing rolls without friction. Of a blade with a mark, the findings of a run say so once the mark whirls.
    """
    if getattr(scene.effects, "wall_friction", None) is None:
        return
    marks = [mark.distance_from_bit for mark in scene.string.marks]
    radius, middle = np.array([(0.5 * piece.contact_diameter, piece.length) for piece in scene.string.pieces]).T
    middle = np.cumsum(middle) - 0.5 * middle
    hole = np.array([scene.hole.radius_at(scene.length - float(place)) for place in middle])
    held = (middle < 2.0 * hole) & (scene.string.bit_end == "pinned")
    for k, piece in enumerate(scene.string.pieces):
        held[k] |= bool(piece.section.blade_diameter) and any(abs(at - middle[k]) <= 0.5 * piece.length for at in marks)
    ratio = np.where(held, 0.0, radius / np.maximum(hole - radius, 1e-12))
    fastest, turns = int(np.argmax(ratio)), extremes(scene).rotation / math.tau
    frames = scene.numerics.frame_rate
    steps = 1.0 / resolution_of(scene)[1] if scene.numerics.accuracy is None else math.inf
    shown = ratio * turns * FRAMES_IN_ORBIT <= frames
    followed = ratio * turns * STEPS_IN_ORBIT <= steps
    if shown.all() and followed.all():
        return
    pieces, worst, units = scene.string.pieces, ratio[fastest] * turns, scene.unit_system
    length = sum(piece.length for piece, good in zip(pieces, shown & followed, strict=True) if not good)
    lacks = []
    if not shown.all():
        lacks.append(
            f"`numerics.frame_rate: {frames:.4g} Hz` shows none above {frames / FRAMES_IN_ORBIT:.3g} Hz, this needs "
            f"{FRAMES_IN_ORBIT * worst:.3g} Hz"
        )
    if not followed.all():
        lacks.append(f"a step of {1e3 / steps:.3g} ms, this needs a step of {1e3 / STEPS_IN_ORBIT / worst:.3g} ms")
    yield (
        f"backward whirl may be missed: rolling along the wall, {pieces[fastest].section.name or 'the string'}, "
        f"{units.text(middle[fastest], 'length')} from the bit, whirls at -{ratio[fastest]:.3g} times the rotation "
        f"(radius over clearance), {worst:.3g} Hz; {'; '.join(lacks)}; so for "
        f"{units.text(length, 'length')} of the string"
    )


def _short_thick(scene: Scene) -> Iterator[str]:
    """Sections that are discs: no beam theory holds where a piece is shorter than thick."""
    sections = scene.string.sections
    start = np.cumsum([0.0, *(section.length for section in sections)])
    for index, own in enumerate(sections):
        beside = [
            other.outer_diameter for other in (*sections[max(index - 1, 0) : index], *sections[index + 1 : index + 2])
        ]
        if own.length >= own.outer_diameter or own.outer_diameter < THICKER * min(beside, default=math.inf):
            continue
        mass, squares = own.mass_per_length * own.length, own.outer_diameter**2 + own.inner_diameter**2
        yield (
            f"`string.sections[{index}]` is {1e3 * own.length:.4g} mm long and {1e3 * own.outer_diameter:.4g} mm "
            "thick: a disc, no beam. Its stiff short elements make the frequencies of `drill-twin modes` uncertain by "
            "rounding, and without `effects.gyroscopic` its rotary inertia is missing; write it in `string.discs`: "
            f"distance_from_bit: {start[index] + 0.5 * own.length:.6g} m, mass: {mass:.4g} kg, polar_inertia: "
            f"{mass * squares / 8.0:.4g} kg m^2, diametral_inertia: "
            f"{mass * (squares / 16.0 + own.length**2 / 12.0):.4g} kg m^2, and lengthen a neighbour by its length"
        )


def _gyroscopic(scene: Scene) -> Iterator[str]:
    if scene.effects.gyroscopic is not None:
        return
    speed = abs(extremes(scene).rotation)
    if any(sum(scene.string.body_of(disc)[1:3]) > 0.0 for disc in scene.string.discs):
        yield "`effects.gyroscopic` is not listed: rotary inertia and gyroscopic moments of discs are left out; list it"
        return
    # of a bending wave at the rotation, (k r)^2 / 2 and twice as much of its gyroscopic split
    radius = max(math.sqrt(tube_constants(tube)[1] / tube_constants(tube)[0]) for tube in sections_of(scene))
    slowest = min(math.sqrt(tube.youngs_modulus / tube.density) for tube in sections_of(scene))
    change = 1.5 * radius * speed / slowest
    if change >= LEAST_GYROSCOPIC:
        yield (
            f"`effects.gyroscopic` is not listed: at {speed * 30.0 / math.pi:.4g} rpm rotary inertia and gyroscopic "
            f"moments change a lateral frequency by about {100.0 * change:.2g} % (first order, of a bending wave at "
            "the rotation); list it"
        )
