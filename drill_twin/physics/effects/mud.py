# SPDX-License-Identifier: Apache-2.0
"""Properties of the mud, for buoyancy, added mass and drag, and its force on a string that oscillates in the hole."""

from collections.abc import Iterator
from typing import Annotated, Any, ClassVar, Literal, NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.compile.jit import kernel
from drill_twin.core.units import Density, Dimensionless, Frequency, Pressure, Viscosity, Within
from drill_twin.physics.effects.config import EffectConfig, Problem
from drill_twin.physics.model import DiscreteModel, Point

VISCOMETER = 511.0
"""Shear rate of the field viscometer at 300 rpm, where it reads the apparent viscosity in cP [1/s] (API RP 13D)."""
NO_ROTATION = 2.0 * np.pi
"""Reference frequency where nothing turns, 1 Hz [rad/s]; chosen, not measured."""
SLOWEST = 0.03
"""Least gap over depth of penetration, sqrt(omega / nu) (R - r_o) [-]. There the coefficients are at their limits
within 1e-4 (`test_viscous_drag.py`); below it rounding takes over."""
SETTLED = 60
"""Iterations of the apparent viscosity; the error at least halves in each, since the shear rate falls with its root."""


class Mud(EffectConfig):
    """Drilling fluid at rest around the string; `gravity` becomes buoyant, drag and added mass are separate effects."""

    density: Annotated[
        Density, Within(above="0 kg/m^3", at_most="4000 kg/m^3", reason="the heaviest muds have 2700; air has 1.2")
    ]
    """Density [kg/m^3]."""
    viscosity: Annotated[Viscosity, Within(at_least="0 Pa s", at_most="10 Pa s", reason="honey has 10")] = 0.0
    """Dynamic viscosity [Pa s], with a `yield_point` the plastic one, with an `index` the viscosity at 511 1/s (the
    reading of a viscometer at 300 rpm in cP); `rotation_drag` and `viscous_drag` need it."""
    yield_point: Annotated[Pressure, Within(at_least="0 Pa", at_most="1000 Pa", reason="muds have 0 to 30")] = 0.0
    """Stress below which a Bingham mud does not flow [Pa]; 1 lbf/100 ft^2 is 0.479 Pa."""
    index: Annotated[Dimensionless, Within(at_least="0.1", at_most="2", reason="muds have 0.3 to 1")] = 1.0
    """Flow index n of a power-law mud, stress ~ rate^n [-]."""
    frequency: Annotated[Frequency, Within(above="0 Hz", at_most="1 kHz")] | None = None
    """Frequency for which the lateral force is computed [Hz]; by default the fastest rotation of the set-points."""
    inside: Literal["mud", "air"] = "mud"
    """Content of the pipe: `mud`, which follows its lateral motion, or `air`, without mass."""

    def problems(self) -> Iterator[Problem]:
        """A yield point or an index without a viscosity."""
        if self.viscosity == 0.0 and (self.yield_point != 0.0 or self.index != 1.0):
            yield (), "expected a `viscosity` above 0 Pa s beside `yield_point` or `index`, found 0 Pa s"

    @property
    def newtonian(self) -> bool:
        """True where the viscosity is the same at any shear rate."""
        return self.yield_point == 0.0 and self.index == 1.0

    def apparent(self, shear_rate: Array) -> Array:
        """Apparent viscosity [Pa s] at shear rates [1/s]: stress over rate of a Herschel-Bulkley fluid (API RP 13D)."""
        thinned = self.viscosity * (shear_rate / VISCOMETER) ** (self.index - 1.0)
        return np.asarray(thinned + (self.yield_point / shear_rate if self.yield_point else 0.0))


class ViscousEffect(EffectConfig):
    """Effect that comes from the viscosity of the mud."""

    requires: ClassVar[tuple[str, ...]] = ("mud",)
    energy_class = "heat"

    def check_against(self, scene: Any) -> Iterator[Problem]:
        """Yield mud without viscosity."""
        if scene.effects.mud is not None and scene.effects.mud.viscosity == 0.0:
            yield (), "expected a viscosity above 0 Pa s in `mud`, found 0 Pa s"


def reference_rate(model: DiscreteModel) -> float:
    """Angular frequency for which constants of the mud hold [rad/s]."""
    if model.fluid.frequency is not None:
        return float(2.0 * np.pi * model.fluid.frequency)
    return model.fastest_rotation or NO_ROTATION


class LateralForce(NamedTuple):
    """Force on a cylinder that oscillates across the hole, over the mass of the mud that it displaces; shape (m,)."""

    mass: Array
    """Added mass [-]."""
    drag: Array
    """Drag over speed [1/s]."""
    shear: Array
    """Largest shear rate on the cylinder over its speed [1/m]."""


def in_annulus(outer: Array, hole: Array, viscosity: Array, rate: float) -> LateralForce:
    """Force of a viscous fluid on a cylinder that oscillates in a concentric hole, linearised Navier-Stokes equations.

    The stream function is (A r + B / r + C I1(lambda r) + D K1(lambda r)) sin(theta), lambda^2 = i omega / nu, at rest
    on the hole and with the cylinder's speed on the cylinder (Chen, Wambsganss and Jendrzejczyk 1976). The force per
    length is -rho pi r_o^2 H a at acceleration a, H = 2 B / (U r_o^2) - 1: added mass Re(H), drag -omega Im(H).

    Args:
        outer: Radii of the cylinder [m], shape (m,).
        hole: Radii of the hole [m], shape (m,).
        viscosity: Kinematic viscosity [m2/s], shape (m,).
        rate: Angular frequency [rad/s].
    """
    from scipy.special import ive, kve  # takes 0.2 s, which a command that computes no motion does not need

    wide = hole / outer
    at_string = np.sqrt(1j) * np.maximum(np.sqrt(rate / viscosity) * outer, SLOWEST / (wide - 1.0))
    at_hole = at_string * wide
    down = np.exp(at_string.real - at_hole.real)  # I1 from hole to string, over I1 at the hole
    up = np.exp(at_string - at_hole)  # K1 from string to hole, over K1 at the string
    one, zero = np.ones_like(at_string), np.zeros_like(at_string)

    def scaled(z: Any) -> Any:
        """I1 and its slope over I1 at the hole, then K1 and its slope over K1 at the string, all but for the decay."""
        i1, k1 = ive(1, z), kve(1, z)
        slopes = at_string * (ive(0, z) - i1 / z), -at_string * (kve(0, z) + k1 / z)
        growing, decaying = ive(1, at_hole), kve(1, at_string)
        return i1 / growing, slopes[0] / growing, k1 / decaying, slopes[1] / decaying

    i, di, k, dk = scaled(at_string)
    i_hole, di_hole, k_hole, dk_hole = scaled(at_hole)
    rows = [
        [one, one, i * down, k],
        [one, -one, di * down, dk],
        [wide * one, one / wide, i_hole, k_hole * up],
        [one, -one / wide**2, di_hole, dk_hole * up],
    ]
    system = np.moveaxis(np.array(rows), -1, 0)
    sides = np.stack([one, one, zero, zero], axis=-1)[..., None]
    uniform, doublet, *_ = np.linalg.solve(system, sides)[..., 0].T
    shear = np.abs(at_string**2 * (1.0 - uniform - doublet)) / outer
    drag = -2.0 * doublet.imag * np.abs(at_string) ** 2 * viscosity / outer**2
    return LateralForce(2.0 * doublet.real - 1.0, drag, shear)


def lateral_force(model: DiscreteModel) -> LateralForce:
    """Force of the mud at the Gauss points, shape (2 n,), at the reference frequency.

    A mud that is not Newtonian has its apparent viscosity at the largest shear rate on a string that swings over the
    whole gap, so smaller motions are braked more than here. Without viscosity the flow is potential (Fritz 1972).
    """
    mud, rate = model.fluid, reference_rate(model)
    radii = np.stack([model.at_places(model.rod.outer_radius), hole_radius(model)], axis=1)
    (outer, hole), back = (found := np.unique(radii, axis=0, return_inverse=True))[0].T, found[1].ravel()
    if mud.viscosity == 0.0:
        none = np.zeros_like(back, float)
        return LateralForce(((hole**2 + outer**2) / (hole**2 - outer**2))[back], none, none)
    viscosity = np.full_like(outer, mud.viscosity)
    for _ in range(1 if mud.newtonian else SETTLED):
        force = in_annulus(outer, hole, viscosity / mud.density, rate)
        viscosity = mud.apparent(force.shear * rate * (hole - outer))
    return LateralForce(*(values[back] for values in force))


def bore_radius(model: DiscreteModel) -> Array:
    """Inner radius of each element [m], shape (n,), from r_i^2 + r_o^2 = 4 EI / EA of a circular tube."""
    rod = model.rod
    square = 4.0 * rod.bending / rod.axial - rod.outer_radius**2
    return np.sqrt(np.where(square > 1e-12 * rod.outer_radius**2, square, 0.0))


def hole_radius(model: DiscreteModel) -> Array:
    """Radius of the hole at the Gauss points [m], shape (2 n,)."""
    return np.asarray(model.wellbore.clearance + model.contact_radius)


def displaced_area(model: DiscreteModel) -> Array:
    """Area of mud displaced by each element [m^2], shape (n,): its ring, or the full circle with air inside.

    The pressure on inner wall, outer wall and shoulders adds up to this buoyancy and makes the axial force the
    effective one, T - p_i A_i + p_o A_o, which governs bending and buckling (Sparks 1984).
    """
    if model.fluid_density == 0.0:
        return np.zeros_like(model.rod.length)
    inside = bore_radius(model) if model.fluid_inside else np.zeros_like(model.rod.length)
    return np.asarray(np.pi * (model.rod.outer_radius**2 - inside**2) + model.joint_area)


@kernel
def resist_across(here: Point, k: float, x: float, y: float, z: float, load: Array) -> None:
    """Add the force -k (1 - t t) times a speed or an acceleration (x, y, z) to a load."""
    along = here.tx * x + here.ty * y + here.tz * z
    load[0] -= k * (x - here.tx * along)
    load[1] -= k * (y - here.ty * along)
    load[2] -= k * (z - here.tz * along)


@kernel
def add_across(here: Point, k: float, stiff: Array) -> None:
    """Add k (1 - t t), the tangent of a force across the string, to the matrix of a load."""
    stiff[0, 0] += k * (1.0 - here.tx * here.tx)
    stiff[1, 1] += k * (1.0 - here.ty * here.ty)
    stiff[2, 2] += k * (1.0 - here.tz * here.tz)
    stiff[0, 1] -= k * here.tx * here.ty
    stiff[1, 0] -= k * here.tx * here.ty
    stiff[0, 2] -= k * here.tx * here.tz
    stiff[2, 0] -= k * here.tx * here.tz
    stiff[1, 2] -= k * here.ty * here.tz
    stiff[2, 1] -= k * here.ty * here.tz
