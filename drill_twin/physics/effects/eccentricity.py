# SPDX-License-Identifier: Apache-2.0
"""Imbalance: the mass centre of each cross-section lies off the centre line and rotates with the spin."""

from collections.abc import Iterator
from typing import Annotated, Any, NamedTuple

import numpy as np
from pydantic import Field

from drill_twin.core.arrays import Array
from drill_twin.core.compile.jit import kernel
from drill_twin.core.units import Angle, Length, Within
from drill_twin.physics.effects.config import EffectConfig, Problem, Seed, too_large
from drill_twin.physics.effects.random_draws import generator, random_line
from drill_twin.physics.model import DiscreteModel, Point, Rod, transverse_axes

Offset = Annotated[Length, Within(at_least="0 m", at_most="1 m", reason="no string is thicker")]
Direction = Annotated[Angle, Within(at_least="-360 deg", at_most="360 deg", reason="a turn")]


class Imbalance(EffectConfig):
    """Mass centre of one section."""

    offset: Offset
    """Distance of the mass centre from the centre line [m]; below the outer radius."""
    angle: Direction = 0.0
    """Direction of the mass centre in the material, from the spin's zero [rad]."""


class Eccentricity(EffectConfig):
    """Mass eccentricity: uniform along the string or by section, plus a random part."""

    across = True
    energy_class = "kept"
    seed_is_of = "rms"

    offset: Offset | None = None
    """Distance of the mass centre from the centre line [m]; below the outer radius."""
    angle: Direction = 0.0
    """Direction of the mass centre in the material, from zero spin [rad]; only with `offset`."""
    sections: Annotated[tuple[Imbalance, ...], Field(max_length=1000)] = ()
    """Instead of `offset` and `angle`: the eccentricity of each section of the string, FROM THE BIT UP."""
    rms: Offset = 0.0
    """Random part: root mean square of its distance from the centre line [m]."""
    correlation_length: Annotated[Length, Within(above="0 m", at_most="20 km", reason="the longest string")] | None = (
        None
    )
    """Random part: correlation length along the string, at which the correlation is exp(-1/2) [m]."""
    seed: Seed = 1
    """Random part: seed; the same seed gives the same string on any mesh."""

    def problems(self) -> Iterator[Problem]:
        """An eccentricity that is defined twice, or in part."""
        if self.offset is not None and self.sections:
            yield (), "expected `offset` or `sections`, found both: give the offset of each section only"
        if self.offset is None and self.angle != 0.0:
            other = "sections`, each with its own" if self.sections else "rms`, which is in all directions"
            yield (), f"expected `angle` with `offset` only, found it beside `{other}"
        if self.offset is None and not self.sections and self.rms == 0.0:
            yield (), "expected an `offset`, `sections`, or a random `rms` above 0 m, found none"
        if self.rms > 0.0 and self.correlation_length is None:
            yield (), "expected a `correlation_length` with `rms`, found none"
        if self.rms == 0.0 and self.correlation_length is not None:
            yield (), "expected an `rms` with `correlation_length`, found none"

    def check_against(self, scene: Any) -> Iterator[Problem]:
        """Yield a mass centre outside the string, or a number of items other than the number of sections."""
        sections = scene.string.sections
        if self.sections and len(self.sections) != len(sections):
            yield (
                ("sections",),
                f"expected one item for each of the {len(sections)} sections of the string, found {len(self.sections)}",
            )
            return
        for index, section in enumerate(sections):
            offset = self.sections[index].offset if self.sections else self.offset or 0.0
            place = ("sections", index, "offset") if self.sections else ("offset" if offset else "rms",)
            yield from too_large(place, offset + self.rms, section.outer_diameter / 2.0, "outer radius", below=True)


class Parameters(NamedTuple):
    """Mass per length times position of the mass centre at zero spin and at a quarter turn, and the inertia added."""

    imbalance: Array  # in the frame `hole` [kg], shape (2 n, 2, 3)
    inertia: Array  # [kg m], shape (2 n,)


def offsets(block: Eccentricity, model: DiscreteModel) -> Array:
    """Mass centre in the material frame at the Gauss points [m], shape (2 n, 2)."""
    own = [part.offset * np.exp(1j * part.angle) for part in block.sections]
    uniform = np.full(model.section.shape, (block.offset or 0.0) * np.exp(1j * block.angle))
    line = np.asarray(model.at_places(np.array(own)[model.section] if own else uniform), dtype=complex)
    if block.correlation_length is not None:
        random = generator(model, block.seed, "eccentricity")
        line = line + block.rms * random_line(model.places, block.correlation_length, random)
    return np.stack([line.real, line.imag], -1)


def parameters(block: Eccentricity, model: DiscreteModel) -> Parameters:
    """Compute imbalance m e, across the axis of the hole, and inertia m e^2 at the Gauss points."""
    place, mass = offsets(block, model), model.at_places(model.rod.line_mass)
    axis = model.wellbore.axis
    x, y = transverse_axes(np.array([[0.0, 0.0, 1.0]]) if axis is None else axis.tangent)
    own_x, own_y = (mass[:, None] * place).T[..., None]
    turned = np.stack([own_x * x + own_y * y, own_x * y - own_y * x], axis=1)
    return Parameters(turned, mass * np.sum(place**2, axis=1))


@kernel
def distributed_load(parameters: Any, rod: Rod, here: Point, half_step: float, load: Array, stiff: Array) -> None:
    """Add the inertia of a mass centre at r + e that rotates with the spin (Jeffcott rotor, Genta 2005).

    -m e_ddot on the line and the couple -t . e x m (r_ddot + e_ddot) on the spin; e is normal to t, the axis of
    the hole (small slopes of the string to it). The weight acts on the centre line.
    """
    law, omega, alpha = parameters.eccentricity, here.spin_rate, here.spin_up
    inertia, acceleration = law.inertia[here.place], (here.ax, here.ay, here.az)
    rate = 1.0 / half_step
    along, across = 0.0, 0.0  # m e and m t x e times the acceleration of the line
    for i in range(3):
        zero, quarter = law.imbalance[here.place, 0, i], law.imbalance[here.place, 1, i]
        e = zero * here.cos_spin + quarter * here.sin_spin
        turned = quarter * here.cos_spin - zero * here.sin_spin  # t x e
        load[i] += e * omega * omega - turned * alpha
        stiff[i, 3] += rate * turned - 2.0 * e * omega - half_step * (turned * omega * omega + e * alpha)
        stiff[3, i] += rate * turned
        along += e * acceleration[i]
        across += turned * acceleration[i]
    load[3] -= across + inertia * alpha
    stiff[3, 3] += rate * inertia - half_step * along
