# SPDX-License-Identifier: Apache-2.0
"""Fatigue at chosen sections: bending moment and stress in the turning material, cycles and damage. No force.

After each step the curvature of the centre line at a section is taken into the frame that turns with the material, and
the stress of `FIBRES` fibres round its surface is counted (`drill_twin.physics.model.rainflow`). Torsion is not
counted.
"""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, NamedTuple

import numpy as np
from pydantic import Field

from drill_twin.core.arrays import Array
from drill_twin.core.compile.jit import kernel
from drill_twin.core.units import Dimensionless, Length, Pressure, Within
from drill_twin.physics.effects import bow
from drill_twin.physics.effects.config import EffectConfig, Problem, repeated_names
from drill_twin.physics.model import DiscreteModel, Rod, locate, youngs_modulus
from drill_twin.physics.model.rainflow import DEPTH, EXTREME, MEMORY, Law, add_stress, total_cycles, total_damage
from drill_twin.physics.model.section_stress import (
    AXIAL_FORCE,
    CYCLES,
    DAMAGE,
    LARGEST_STRESS,
    MOMENT_X,
    MOMENT_Y,
    SCALARS,
    STRESS,
    material_strain,
    strain_samples,
)
from drill_twin.physics.model.steel import CURVES, GRADES, Steel, steel_of

Grade = Literal["E75", "X95", "G105", "S135"]


class FatigueSection(EffectConfig):
    """Cross-section of the string whose stress is counted."""

    name: Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_]*$", max_length=60)]
    """Name on the topic: letters, digits and underscores, a letter first."""
    distance_from_bit: Annotated[Length, Within(at_least="0 m", at_most="20 km")] | None = None
    """Arc length from the bit [m]; either this or `measured_depth`."""
    measured_depth: Annotated[Length, Within(at_least="0 m", at_most="20 km")] | None = None
    """Distance from the top along the string [m]."""
    grade: Grade | None = None
    """Grade of its steel; left out: by the yield strength of the string's section there, else E75."""
    stress_concentration: Annotated[Dimensionless, Within(at_least="1", at_most="20")] = 1.0
    """Local over nominal stress range, as of a connection; the published stress is nominal."""

    def problems(self) -> Iterator[Problem]:
        """Two places, or none."""
        if (self.distance_from_bit is None) == (self.measured_depth is None):
            found = "none" if self.distance_from_bit is None else "both"
            yield (), f"expected either `distance_from_bit` or `measured_depth`, found {found}"

    def distance(self, length: float) -> float:
        """Arc length from the bit [m], of a string of a length [m]."""
        return length - self.measured_depth if self.measured_depth is not None else self.distance_from_bit or 0.0

    def steel(self, yield_strength: float | None) -> Steel:
        """Its steel, in a section of the string with a yield strength [Pa]."""
        return GRADES[self.grade] if self.grade is not None else steel_of(yield_strength)


class SNLine(EffectConfig):
    """S-N curve of one slope: N = cycles (stress_range / S)^slope."""

    stress_range: Annotated[Pressure, Within(above="0 Pa", at_most="100 GPa")]
    """Stress range [Pa] that is endured for `cycles`."""
    cycles: Annotated[Dimensionless, Within(at_least="1", at_most="1e12")] = 1e6
    """Cycles to failure at that range."""
    slope: Annotated[Dimensionless, Within(at_least="1", at_most="30")]
    """Slope m."""


FIBRES = 16
"""Fibres round the circumference: a direction of bending is at most pi / 16 off one, 2 % of its stress."""
SMALLEST = 0.01
"""Smallest range that is counted, over the range of the curve at its knee."""
_SHEET = 1e-12  # relative length by which a section may lie beyond the string
if TYPE_CHECKING:
    Curve = str
else:
    Curve = Literal[tuple(CURVES)]


class Fatigue(EffectConfig):
    """Stress and fatigue damage at chosen sections of the string; it does not act on the motion."""

    requires: ClassVar[tuple[str, ...]] = ("stretch", "torsion")
    energy_class = "kept"

    sections: Annotated[tuple[FatigueSection, ...], Field(min_length=1, max_length=100)]
    """Cross-sections, in any order."""
    curve: Curve = "dnv_high_strength"
    """S-N curve: `api_rp_7g`, or a curve of DNV-RP-C203, such as `dnv_b1`."""
    line: SNLine | None = None
    """An S-N curve of your own, in place of `curve`."""
    mean_stress: Literal["goodman", "none"] = "goodman"
    """Correction of the range by a tensile mean stress: divided by 1 - mean / tensile strength, or none."""
    smallest_range: Annotated[Pressure, Within(above="0 Pa", at_most="1 GPa")] | None = None
    """Smallest stress range that is counted [Pa]; left out: 1 % of that at the knee of the curve."""

    def check_against(self, scene: Any) -> Iterator[Problem]:
        """Yield a curve beside a line, a section beyond the string, and a name used twice."""
        if self.line is not None and self.curve != "dnv_high_strength":
            yield ("line",), f'expected either `curve` or `line`, found both ("{self.curve}")'
        for index, section in enumerate(self.sections):
            distance = section.distance(scene.string.length)
            if not 0.0 <= distance <= scene.string.length * (1.0 + _SHEET):
                key = "distance_from_bit" if section.measured_depth is None else "measured_depth"
                yield (
                    ("sections", index, key),
                    (
                        f'expected "{section.name}" on the string ({scene.string.length:.6g} m long), '
                        f"found {getattr(section, key):.6g} m"
                    ),
                )
        yield from repeated_names("sections", self.sections)

    def yield_strengths(self, scene: Any) -> dict[str, float]:
        """Yield strength of each section by name [Pa], in a `drill_twin.scene.Scene`."""
        at = scene.string.section_at
        return {
            section.name: section.steel(at(section.distance(scene.length)).yield_strength).yield_strength
            for section in self.sections
        }


class Parameters(NamedTuple):
    """Places and constants of s sections, the law, and their memory; floats only, for checkpoints."""

    element: Array  # (s,)
    share: Array  # (s,) coordinate in the element, 0 to 1
    first: Array  # (s, 4) first derivatives of the shape functions
    second: Array  # (s, 4)
    samples: Array  # (s, 3) weights of the stretch at the ends and the inner sample of the element
    stiffness: Array  # (s, 3) E, E r_o per curvature, EI [Pa, Pa m, N m2]
    axial: Array  # (s,) EA [N]
    bow: Array  # (s, 2) stress-free curvature, fixed in the material [1/m]
    strength: Array  # (s, 2) stress concentration, tensile strength [Pa]
    circle: Array  # (FIBRES, 2) cos and sin
    frame: Array  # (3, 4) of the bit (drill_twin.dynamics.solver.boundary)
    law: Law
    memory: Array  # (s, FIBRES, MEMORY)
    points: Array  # (s, FIBRES, DEPTH) turning points [Pa]
    halves: Array  # (s, FIBRES, DEPTH) damage of their half cycles, summed from the first sample on
    seen: Array  # (s, SCALARS), see drill_twin.physics.model.section_stress


def parameters(block: Fatigue, model: DiscreteModel) -> Parameters:
    """Locate the sections in the mesh, and set up their memory."""
    rod, count = model.rod, len(block.sections)
    places = np.clip([section.distance(model.string_length) for section in block.sections], 0.0, model.string_length)
    element, share, shapes = locate(rod, places)
    radius, axial, bending = rod.outer_radius[element], rod.axial[element], rod.bending[element]
    modulus = youngs_modulus(rod)[element]
    yields = (model.yield_strength[model.section[e]] for e in element)
    steels = [section.steel(strength) for section, strength in zip(block.sections, yields, strict=True)]
    tensile = [steel.tensile_strength if block.mean_stress == "goodman" else np.inf for steel in steels]
    line = block.line
    curve = CURVES[block.curve] if line is None else (line.stress_range, line.cycles, line.slope, line.slope)
    memory = np.zeros((count, FIBRES, MEMORY))
    memory[..., EXTREME] = np.nan
    angle = 2.0 * np.pi * np.arange(FIBRES) / FIBRES
    return Parameters(
        element=element.astype(float), share=share, first=shapes[:, 1].copy(), second=shapes[:, 2].copy(),
        samples=strain_samples(rod, element, share),
        stiffness=np.stack([modulus, modulus * radius, bending], -1), axial=axial,
        bow=_bow(model, places),
        strength=np.array([(s.stress_concentration, t) for s, t in zip(block.sections, tensile, strict=True)]),
        circle=np.stack([np.cos(angle), np.sin(angle)], -1), frame=model.bit_frame,
        law=Law(*curve, block.smallest_range or SMALLEST * curve[0]),
        memory=memory, points=np.zeros((count, FIBRES, DEPTH)), halves=np.zeros((count, FIBRES, DEPTH)),
        seen=np.zeros((count, len(SCALARS))),
    )  # fmt: skip


def _bow(model: DiscreteModel, places: Array) -> Array:
    """Stress-free curvature at places of the string [1/m], shape (s, 2)."""
    if model.bow is None:
        return np.zeros((places.size, 2))
    curvature = bow.parameters(model.bow, model).moment / model.at_places(model.rod.bending)[:, None]
    return np.stack([np.interp(places, model.places, part) for part in curvature.T], -1)


@kernel
def after_step(parameters: Any, rod: Rod, command: Array, time: float, step: float, u: Array, v: Array) -> None:
    """Count the stress of all fibres, and note what is read of each section."""
    law = parameters.fatigue
    for s in range(law.element.shape[0]):
        e, share, first, second = int(law.element[s]), law.share[s], law.first[s], law.second[s]
        x, y, strain = material_strain(rod, e, share, first, second, law.samples[s], law.bow[s], law.frame, u)
        stress, bending = law.stiffness[s, 0] * strain, law.stiffness[s, 1]
        factor, tensile, seen = law.strength[s, 0], law.strength[s, 1], law.seen[s]
        for k in range(FIBRES):
            value = stress - bending * (x * law.circle[k, 0] + y * law.circle[k, 1])
            memory, points, halves = law.memory[s, k], law.points[s, k], law.halves[s, k]
            if add_stress(law.law, factor, tensile, value, memory, points, halves):
                damage, cycles = total_damage(memory, halves), total_cycles(memory)
                if damage > seen[DAMAGE] or (damage == seen[DAMAGE] and cycles > seen[CYCLES]):
                    seen[DAMAGE], seen[CYCLES] = damage, cycles
        seen[MOMENT_X], seen[MOMENT_Y] = law.stiffness[s, 2] * x, law.stiffness[s, 2] * y
        seen[AXIAL_FORCE] = law.axial[s] * strain
        seen[STRESS] = abs(stress) + bending * np.sqrt(x * x + y * y)
        seen[LARGEST_STRESS] = max(seen[LARGEST_STRESS], seen[STRESS])
