# SPDX-License-Identifier: Apache-2.0
"""Rigid discs on the string (`string.discs`): mass, weight, polar inertia and unbalance at a node of the mesh.

A part of the string, not an effect: a scene that lists a disc has its mass whatever effects it lists. Its diametral
inertia and its gyroscopic moment are the effect `gyroscopic`.
"""

import math
from collections.abc import Iterator
from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from drill_twin.core.arrays import Array
from drill_twin.core.compile.jit import kernel
from drill_twin.core.units import Angle, Density, Inertia, Length, Mass, Unbalance, Within
from drill_twin.physics.effects.config import EffectConfig, Problem
from drill_twin.physics.model import DiscreteModel, Rod, transverse_axes

PartName = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_]*$", max_length=60)]
"""Name of a part of the string, valid inside a joint name on a topic."""
PartPlace = Annotated[Length, Within(at_least="0 m", at_most="20 km")]
"""Arc length from the bit [m]."""
DiscMass = Annotated[Mass, Within(at_least="0 kg", at_most="1e6 kg", reason="a whole string has 1e5")]
DiscInertia = Annotated[Inertia, Within(at_least="0 kg m^2", at_most="1e9 kg m^2")]
_SIZES = ("outer_diameter", "width")


class Disc(EffectConfig):
    """Rigid disc, collar or tool on the string; a point mass has neither inertia nor size.

    It does not touch the wall: contact is the section's, with its `blade_diameter`.
    """

    name: PartName
    """Name in reports."""
    distance_from_bit: PartPlace
    """Arc length from the bit [m]; a node of the mesh is put there."""
    mass: DiscMass | None = None
    """Mass [kg]; left out: from the dimensions."""
    polar_inertia: DiscInertia | None = None
    """Moment of inertia about its own axis, along the string [kg m^2]; left out: from the dimensions, else 0. The
    unbalance U adds U^2 over the mass."""
    diametral_inertia: DiscInertia | None = None
    """Moment of inertia about a diameter [kg m^2], for the effect `gyroscopic`; left out: as above."""
    outer_diameter: Annotated[Length, Within(above="0 m", at_most="100 m")] | None = None
    """Outer diameter [m]; with `width`."""
    width: Annotated[Length, Within(above="0 m", at_most="100 m")] | None = None
    """Width along the string [m]."""
    bore: Annotated[Length, Within(at_least="0 m", at_most="100 m")] | None = None
    """Bore [m]; left out: the outer diameter of the string there."""
    density: Annotated[Density, Within(above="0 kg/m^3", at_most="30000 kg/m^3", reason="osmium has 22600")] = 7850.0
    """Density of its material [kg/m^3], where the mass is left out; left out: steel's."""
    unbalance: Annotated[Unbalance, Within(at_least="0 kg m", at_most="1e6 kg m")] | None = None
    """Unbalance: mass times its distance from the string's axis [kg m]; or `weight` and `radius`."""
    weight: Annotated[Mass, Within(at_least="0 kg", at_most="1e6 kg")] | None = None
    """Mass of a balance weight, counted as part of `mass` [kg]; with `radius`."""
    radius: Annotated[Length, Within(at_least="0 m", at_most="50 m")] | None = None
    """Distance of this weight from the string's axis [m]."""
    angle: Annotated[Angle, Within(at_least="-360 deg", at_most="360 deg", reason="a turn")] = 0.0
    """Direction of the unbalance in the material, from the spin's zero, in the sense of rotation [rad]."""

    def problems(self) -> Iterator[Problem]:
        """Mass, dimensions or unbalance that are defined twice, or in part."""
        given = [key for key in _SIZES if getattr(self, key) is not None]
        if len(given) == 1:
            yield (), f"expected both or neither of `{_SIZES[0]}` and `{_SIZES[1]}`, found only `{given[0]}`"
        if self.mass is None and not given:
            yield (), "expected a `mass`, or `outer_diameter` and `width`, found neither"
        if self.bore is not None and (self.outer_diameter is None or self.bore >= self.outer_diameter):
            yield (), f"expected a `bore` below the `outer_diameter`, found {self.bore:.6g} m"
        if (self.weight is None) != (self.radius is None) or (self.weight is not None and self.unbalance is not None):
            yield (), "expected an `unbalance`, or `weight` and `radius`, or none of them, found others"
        if self.mass is not None and (self.weight or 0.0) > self.mass:
            yield (
                (),
                f"expected a `weight` that is part of the `mass` ({self.mass:.6g} kg), found {self.weight:.6g} kg",
            )
        if self.mass == 0.0 and self.moment > 0.0:
            yield (), "expected a `mass` above 0 kg with an unbalance, found 0 kg"
        if self.angle != 0.0 and self.moment == 0.0:
            yield (), "expected an `angle` with an unbalance only, found it without one"

    @property
    def moment(self) -> float:
        """Unbalance [kg m]."""
        return (self.weight or 0.0) * (self.radius or 0.0) if self.unbalance is None else self.unbalance

    def body(self, shaft: float) -> tuple[float, float, float, float]:
        """Mass [kg], polar and diametral inertia [kg m^2] and volume [m^3] on a string of a diameter [m].

        A ring about its centre: m (R^2 + r^2) / 2 and m (3 (R^2 + r^2) + w^2) / 12; without dimensions the volume, and
        so the buoyancy, is 0.
        """
        outer, width = self.outer_diameter or 0.0, self.width or 0.0
        bore = min(shaft, outer) if self.bore is None else self.bore
        volume = math.pi / 4.0 * (outer**2 - bore**2) * width
        mass, squares = self.density * volume if self.mass is None else self.mass, 0.25 * (outer**2 + bore**2)
        polar, diametral = (0.5 * mass * squares, mass * (3.0 * squares + width**2) / 12.0) if outer else (0.0, 0.0)
        polar = polar if self.polar_inertia is None else self.polar_inertia
        return mass, polar, diametral if self.diametral_inertia is None else self.diametral_inertia, volume


class Bodies(NamedTuple):
    """The d discs of a meshed string; in the model for effects that need them."""

    node: NDArray[np.int64]  # (d,)
    mass: Array  # [kg], shape (d,)
    polar: Array  # [kg m2], shape (d,)
    diametral: Array  # [kg m2], shape (d,)
    weight: Array  # less buoyancy [N], shape (d,); 0 without the effect `gravity`


class Parameters(NamedTuple):
    """The d discs as the kernel takes them."""

    node: NDArray[np.int64]  # (d,)
    mass: Array  # [kg], shape (d,)
    polar: Array  # [kg m2], shape (d,)
    weight: Array  # [N], shape (d, 3)
    unbalance: Array  # at zero spin and at a quarter turn [kg m], shape (d, 2, 3)


def parameters(discs: tuple[Disc, ...], model: DiscreteModel) -> Parameters:
    """Weight along the vertical and unbalance across the axis of the hole; the low side of an inclined hole is +x."""
    bodies, down = model.bodies, np.array([np.sin(model.inclination), 0.0, -np.cos(model.inclination)])
    x, y = transverse_axes(model.directions[bodies.node])
    size = np.array([disc.moment * np.exp(1j * disc.angle) for disc in discs])[:, None]
    # about the string's axis: the mass centre is off it by U / m (Steiner), or a light disc would gain energy
    polar = bodies.polar + np.abs(size[:, 0]) ** 2 / np.maximum(bodies.mass, 1e-300)
    turned = np.stack([size.real * x + size.imag * y, size.real * y - size.imag * x], axis=1)
    return Parameters(bodies.node, bodies.mass, polar, bodies.weight[:, None] * down, turned)


@kernel
def node_load(
    parameters: Any, rod: Rod, time: float, half_step: float, u: Array, v: Array, v_old: Array, nodes: Array
) -> None:
    """Add m r_ddot - w, the unbalance of a mass centre that turns with the spin, and Ip psi_ddot.

    The unbalance U = m e acts as in `drill_twin.physics.effects.eccentricity`; Ip is about the string's axis.
    """
    law, rate = parameters.discs, 1.0 / half_step
    for k in range(law.node.shape[0]):
        i, mass, polar = law.node[k], law.mass[k], law.polar[k]
        out, omega, alpha = nodes[i], v[i, 6], rate * (v[i, 6] - v_old[i, 6])
        cos, sin = np.cos(u[i, 6]), np.sin(u[i, 6])
        along, across = 0.0, 0.0
        for c in range(3):
            acceleration = rate * (v[i, c] - v_old[i, c])
            zero, quarter = law.unbalance[k, 0, c], law.unbalance[k, 1, c]
            e, turned = zero * cos + quarter * sin, quarter * cos - zero * sin
            out[c, c] += rate * mass
            out[c, 7] += mass * acceleration - law.weight[k, c] - e * omega * omega + turned * alpha
            out[c, 6] += rate * turned - 2.0 * e * omega - half_step * (turned * omega * omega + e * alpha)
            out[6, c] += rate * turned
            along += e * acceleration
            across += turned * acceleration
        out[6, 6] += rate * polar - half_step * along
        out[6, 7] += polar * alpha + across
