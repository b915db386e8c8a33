# SPDX-License-Identifier: Apache-2.0
"""Initial bow: stress-free curvature fixed in the material, rotating with the spin."""

from collections.abc import Iterator
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.compile.jit import kernel
from drill_twin.core.units import Angle, Length, Within
from drill_twin.physics.effects.config import EffectConfig, Problem, Seed, too_large
from drill_twin.physics.effects.random_draws import generator, random_line
from drill_twin.physics.model import DiscreteModel, Rod, Strain, rotate_to_tangent
from drill_twin.physics.model.section import COUPLE, MX, MY, MZ


class Bow(EffectConfig):
    """Initial crookedness of the string, an imperfection from which buckling and whirl develop."""

    across = True
    energy_class = "kept"
    seed_is_of = "correlation_length"

    amplitude: Annotated[Length, Within(at_least="0 m", at_most="10 m", reason="the widest hole")]
    """Deflection of the stress-free string from the straight line [m], below the clearance: at mid-span, or the root
    mean square of a random bow."""
    shape: Literal["half_wave", "uniform", "random"] = "half_wave"
    """`half_wave`: one half sine over the length; `uniform`: constant curvature; `random`: crooked in both directions,
    with a Gaussian correlation along the string."""
    angle: Annotated[Angle, Within(at_least="-360 deg", at_most="360 deg", reason="a turn")] = 0.0
    """Direction of the bow in the material, from the spin's zero [rad]."""
    correlation_length: Annotated[Length, Within(above="0 m", at_most="20 km", reason="the longest string")] | None = (
        None
    )
    """Random bow: correlation length along the string, at which the correlation is exp(-1/2) [m]."""
    seed: Seed = 1
    """Random bow: seed; the same seed gives the same string on any mesh."""

    def problems(self) -> Iterator[Problem]:
        """A random bow without a length, or a length of another bow."""
        if (self.shape == "random") != (self.correlation_length is not None):
            found = "none" if self.correlation_length is None else f'one with shape "{self.shape}"'
            yield (), f'expected a `correlation_length` with shape "random" and only there, found {found}'

    def check_against(self, scene: Any) -> Iterator[Problem]:
        """Yield an amplitude above the clearance."""
        clearance = scene.least_clearance
        yield from too_large(("amplitude",), self.amplitude, clearance, "clearance in the hole", below=True)


class Parameters(NamedTuple):
    """EI times the stress-free curvature in the material [N m], shape (2 n, 2)."""

    moment: Array


def parameters(block: Bow, model: DiscreteModel) -> Parameters:
    """Compute the curvature of a half sine wave or an arc with the amplitude at mid-span, or of a random line."""
    length = model.string_length
    curvature = np.full(model.places.shape, -8.0 * block.amplitude / length**2 + 0.0j)
    if block.shape == "half_wave":
        curvature = -block.amplitude * (np.pi / length) ** 2 * np.sin(np.pi * model.places / length) + 0.0j
    if block.correlation_length is not None:
        random = generator(model, block.seed, "bow")
        curvature = block.amplitude * random_line(model.places, block.correlation_length, random, derivative=2)
    moment = model.at_places(model.rod.bending) * curvature * np.exp(1j * block.angle)
    return Parameters(np.stack([moment.real, moment.imag], -1))


@kernel
def section_stress(parameters: Any, rod: Rod, strain: Strain, half_step: float, resultants: Array) -> None:
    """Subtract EI q_0, with q_0 fixed in the material: the smallest rotation of z onto t, then the spin."""
    own_x, own_y = parameters.bow.moment[strain.place, 0], parameters.bow.moment[strain.place, 1]
    turn_x, turn_y = strain.cos_psi, strain.sin_psi
    cx, cy = own_x * turn_x - own_y * turn_y, own_x * turn_y + own_y * turn_x
    mx, my, mz = rotate_to_tangent(strain.tx, strain.ty, strain.tz, cx, cy)
    resultants[MX] -= mx
    resultants[MY] -= my
    resultants[MZ] -= mz
    # m . (t x q_0) with m = EI (q - q_0), and t x q_0 is normal to q_0
    resultants[COUPLE] += -(mx * strain.px + my * strain.py + mz * strain.pz)
