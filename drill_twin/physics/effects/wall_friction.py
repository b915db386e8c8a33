# SPDX-License-Identifier: Apache-2.0
"""Friction of the string on the wall, on the slip velocity of the contact point including the spin."""

from collections.abc import Callable, Iterator
from typing import Annotated, Any, ClassVar, Literal, NamedTuple

import numpy as np
from pydantic import Field

from drill_twin.core.arrays import Array, Pair, Triple
from drill_twin.core.compile.jit import kernel
from drill_twin.core.units import Dimensionless, InverseSpeed, Speed, Within, show
from drill_twin.physics.effects.config import DepthInterval, EffectConfig, Problem, out_of_order
from drill_twin.physics.effects.friction_dual import arctan_size, dual_variable, step_limit, step_size
from drill_twin.physics.effects.wall import Contact, contact_force
from drill_twin.physics.model import DiscreteModel, Point, Rod

ACCURACY = 1e6  # steepness of the regularised sign, where none is given [s/m]
Quad = tuple[float, float, float, float]
SideFriction = tuple[float, float, float, float, float, float]
Coefficient = Annotated[Dimensionless, Within(at_least="0", at_most="5")]
SlipSpeed = Annotated[Speed, Within(above="0 m/s", at_most="100 m/s")] | None


class FrictionInterval(DepthInterval):
    """Interval of the hole with a friction coefficient of its own, such as its casing."""

    coefficient: Coefficient
    """Friction coefficient there at low slip speed [-]; `sliding` keeps its proportion to it."""


class WallFriction(EffectConfig):
    """Friction force mu(v) N sign(v) against the slip velocity v, mu(v) = mu_d + (mu - mu_d) / (1 + delta |v|).

    With an `exponent` n instead Stribeck's law, mu(v) = mu_d + (mu - mu_d) exp(-(delta |v|)^n) (Armstrong-Helouvry,
    Dupont and Canudas de Wit 1994): the larger n, the nearer to a threshold at the slip speed 1 / delta.

    sign(v) is v / sqrt(v^2 + c^2), c = pi / (2 xi), or 2/pi arctan(xi v) as in the paper's Eq. 10. Slope at zero slip
    and limits are the same; at v = c arctan gives 0.64 and the other 0.71, at v = 10 c 0.96 and 0.995.

    With `static_speed` v_s and `dynamic_speed` v_d instead the law of multibody codes (contact force of ADAMS): a cubic
    STEP from -mu at -v_s to mu at v_s, and another down to mu_d at v_d. Below v_s the contact creeps.
    """

    requires: ClassVar[tuple[str, ...]] = ("wall",)
    energy_class = "heat"
    disabled_for_static = ("coefficient", "sliding")

    coefficient: Coefficient
    """Friction coefficient mu at low slip speed [-], outside `intervals`."""
    decay: Annotated[InverseSpeed, Within(at_least="0 s/m", at_most="1e4 s/m")] = 0.0
    """Decrease of friction with slip speed, delta [s/m]; 0 = Coulomb."""
    sliding: Coefficient = 0.0
    """Friction coefficient at high slip speed, mu_d [-], which `decay` leads to; not above `coefficient`."""
    exponent: Annotated[Dimensionless, Within(at_least="1", at_most="20")] | None = None
    """Exponent n of Stribeck's law [-]; left out: the hyperbola."""
    accuracy: Annotated[InverseSpeed, Within(at_least="1 s/m", at_most="1e12 s/m")] = ACCURACY
    """Steepness xi of the regularised sign at zero slip [s/m]."""
    sign: Literal["root", "arctan"] = "root"
    """Regularised sign of the slip: `root` v / sqrt(v^2 + c^2); `arctan` 2/pi arctan(xi v), as the paper has it."""
    static_speed: SlipSpeed = None
    """Slip speed v_s at which friction is mu, by a STEP through zero slip [m/s]; left out: the sign and its fall."""
    dynamic_speed: SlipSpeed = None
    """Slip speed v_d, above v_s, from which friction is mu_d, by a STEP [m/s]."""
    intervals: Annotated[tuple[FrictionInterval, ...], Field(max_length=1000)] = ()
    """Intervals of the hole with another coefficient, such as casing, from the top down."""

    def problems(self) -> Iterator[Problem]:
        """Coefficients, laws or intervals that contradict each other."""
        if self.sliding > self.coefficient:
            yield ((), f"expected `sliding` not above `coefficient` ({self.coefficient:g}), found {show(self.sliding)}")
        low, high = self.static_speed, self.dynamic_speed
        if (low is None) != (high is None):
            yield (), "expected `static_speed` and `dynamic_speed` together, found one of them"
        if low is not None and high is not None and high <= low:
            yield (), f"expected `dynamic_speed` above `static_speed` ({low:g} m/s), found {show(high)}"
        own = self.decay > 0.0 or self.exponent is not None or self.sign != "root" or self.accuracy != ACCURACY
        if low is not None and own:
            yield (
                (),
                (
                    "expected no `decay`, `exponent`, `sign` or `accuracy` beside `static_speed`, which joins mu "
                    "and mu_d itself"
                ),
            )
        falls = low is not None or "decay" in self.model_fields_set  # a decay of 0 s/m, if given, is a limit of the law
        if not falls and (self.sliding > 0.0 or self.exponent is not None):
            yield (), "expected a `decay` with `sliding` or `exponent`, found none: friction would not fall"
        yield from out_of_order(self.intervals)
        if self.intervals and self.coefficient == 0.0:
            yield (), "expected a `coefficient` above 0 beside `intervals`, which scale the law, found 0"

    @property
    def variant(self) -> str:
        """The law, by the names of its additions to the default law."""
        falls = ("stribeck",) if self.exponent is not None else ("sliding",) if self.sliding > 0.0 else ()
        if self.static_speed is not None:
            return "step"
        return "_".join((("arctan",) if self.sign == "arctan" else ()) + falls)

    def scale_at(self, depth: Array) -> Array:
        """Friction at measured depths over the law's [-], shape (p,); the lower interval counts where two meet."""
        scale = np.ones(np.shape(depth))
        if self.coefficient > 0.0:  # friction left out: scales do not matter
            for interval in self.intervals:
                scale[(depth >= interval.top) & (depth < interval.bottom)] = interval.coefficient / self.coefficient
        return scale


class Parameters(NamedTuple):
    """Coefficient, decay with slip [s/m], slip below which the contact sticks [m/s], the last Newton iterate, the
    coefficient at high slip, and the exponent of Stribeck's law.
    """  # in this order: LLVM joins loads of neighbours, and with that the last bits of the result change

    coefficient: float
    decay: float
    creep: float
    memory: (
        Array  # per Gauss point: slip across and along, its smoothed size, dual across and along, iteration; (2 n, 6)
    )
    sliding: float
    exponent: float
    scale: Array  # friction at the Gauss points over the law's friction [-]; shape (2 n,)
    low: float  # slip speed of static friction [m/s]
    high: float  # and of dynamic friction


def parameters(block: WallFriction, model: DiscreteModel) -> Parameters:
    """Compute the creep from the initial slope of the paper's arctan: 2 xi / pi = 1 / creep."""
    memory = np.zeros((model.places.size, 6))
    memory[:, 5] = -1.0
    creep = np.pi / (2.0 * block.accuracy)
    scale = block.scale_at(model.string_length - model.places)
    return Parameters(
        block.coefficient, block.decay, creep, memory, block.sliding, block.exponent or 0.0, scale,
        block.static_speed or 0.0, block.dynamic_speed or 0.0,
    )  # fmt: skip


class Friction(NamedTuple):
    """Friction over the normal force [-], around the hole and along it, and its slopes by the slip [s/m]."""

    around: float
    along: float
    by_around: float  # of the part around the hole, by the slip around it
    mixed: float  # of one part by the other slip
    by_along: float


@kernel
def unit_friction(
    law: Parameters, here: Point, around: float, along: float, arctan: bool, sliding: bool, stribeck: bool, step: bool
) -> Friction:
    """Friction for a normal force of 1 N/m at the slip of a point around the hole and along it [m/s].

    The last four arguments choose the law. Callers pass constants, so the other laws leave no machine code.
    """
    slip, steep, falling = np.sqrt(around * around + along * along), 0.0, 1.0
    if step:
        size, bend = step_size(law, slip)
        limit, excess = step_limit(law, slip)
    else:
        falling = 1.0 + law.decay * slip
        if arctan:
            size, bend = arctan_size(law, slip)
        else:
            size, bend = np.sqrt(slip * slip + law.creep * law.creep), 1.0
        if stribeck:
            steep = (law.decay * slip) ** law.exponent
            excess = (law.coefficient - law.sliding) * np.exp(-steep)
            limit = law.sliding + excess
        elif sliding:
            excess = (law.coefficient - law.sliding) / falling
            limit = law.sliding + excess
        else:
            excess = limit = law.coefficient / falling
    excess, limit = law.scale[here.place] * excess, law.scale[here.place] * limit
    st, sz = around / size, along / size
    dt, dz = dual_variable(law.memory[here.place], here.first_iteration, here.iteration, around, along, size, bend)
    # the limit decreases with slip (without a branch; negligible within the creep)
    if step:
        fall = excess / max(slip, law.low)
    elif stribeck:
        slower = max(slip, law.creep)
        fall = excess * law.exponent * steep / (slower * slower)
    else:
        fall = excess * law.decay / (falling * max(slip, law.creep))
    scale = limit / size
    return Friction(
        limit * st, limit * sz, scale * (1.0 - bend * dt * st) - fall * st * around,
        -0.5 * bend * scale * (dt * sz + dz * st) - fall * st * along,
        scale * (1.0 - bend * dz * sz) - fall * sz * along,
    )  # fmt: skip


@kernel
def row(
    stiff: Array, i: int, at: Contact, own: Triple, slip: Triple, press_slope: Pair, swung: Triple, round_: Quad
) -> None:
    """Add a row of the tangent, written out for vectorisation; `own` is its part of c, t and n."""
    on_c = slip[0] * own[0] + slip[1] * own[1] + swung[0] * own[0] + swung[1] * own[1] + swung[2] * own[2]
    on_t = slip[1] * own[0] + slip[2] * own[1]
    on_n = press_slope[0] * own[0] + press_slope[1] * own[1]
    stiff[i, 0] += on_c * round_[0] + on_t * at.tx + on_n * at.nx
    stiff[i, 1] += on_c * round_[1] + on_t * at.ty + on_n * at.ny
    stiff[i, 2] += on_c * round_[2] + on_t * at.tz + on_n * at.nz
    stiff[i, 3] += (slip[0] * own[0] + slip[1] * own[1]) * round_[3]


def bind(
    *, arctan: bool = False, sliding: bool = False, stribeck: bool = False, step: bool = False
) -> tuple[Callable[..., None], Callable[..., SideFriction]]:
    """The load on the wall for one law, and the friction on a string that follows the hole."""

    @kernel
    def distributed_load(parameters: Any, rod: Rod, here: Point, half_step: float, load: Array, stiff: Array) -> None:
        """Add friction against the slip of the contact point, v.c + r psi_dot around and v.t along the hole.

        mu(s) N sign(s) (paper Eq. 10), with t the hole's axis, n the outward normal and c = t x n.
        """
        at = contact_force(parameters.wall, here, half_step)
        if at.force > 0.0:
            r = parameters.wall.lever[here.place]
            tx, ty, tz = at.tx, at.ty, at.tz
            cx, cy, cz = ty * at.nz - tz * at.ny, tz * at.nx - tx * at.nz, tx * at.ny - ty * at.nx
            around = cx * here.vx + cy * here.vy + cz * here.vz + r * here.spin_rate
            along = tx * here.vx + ty * here.vy + tz * here.vz
            rub = unit_friction(parameters.wall_friction, here, around, along, arctan, sliding, stribeck, step)
            ft, fz = -at.force * rub.around, -at.force * rub.along
            load[0] += ft * cx + fz * tx
            load[1] += ft * cy + fz * ty
            load[2] += ft * cz + fz * tz
            load[3] += r * ft
            slopes = (at.force * rub.by_around, at.force * rub.mixed, at.force * rub.by_along)
            # friction depends on the normal force: unsymmetric
            press = (at.slope * rub.around, at.slope * rub.along)
            swung = (at.swing * rub.around, at.swing * rub.along, half_step * ft / at.radius)
            # rows of the force along x, y, z and of the couple about the axis, with lever r
            row(stiff, 0, at, (cx, tx, at.nx), slopes, press, swung, (cx, cy, cz, r))
            row(stiff, 1, at, (cy, ty, at.ny), slopes, press, swung, (cx, cy, cz, r))
            row(stiff, 2, at, (cz, tz, at.nz), slopes, press, swung, (cx, cy, cz, r))
            row(stiff, 3, at, (r, 0.0, 0.0), slopes, press, swung, (cx, cy, cz, r))

    @kernel
    def side_friction(parameters: Any, here: Point, along: float, across: float) -> SideFriction:
        """Friction on a string that follows the hole, pressed to its wall by a load across the hole.

        The wall carries the load across the hole together with the friction around it, N^2 (1 + (mu s_t)^2) = W^2, as
        a pipe that turns climbs its wall.

        Args:
            parameters: Of the effects.
            here: The point.
            along: Speed along the hole [m/s].
            across: Load across the hole W [N/m].

        Returns:
            Force of the wall, friction along the hole, couple, and minus their slopes: z by z, z by spin, spin by spin.
        """
        r = parameters.wall.lever[here.place]
        rub = unit_friction(parameters.wall_friction, here, r * here.spin_rate, along, arctan, sliding, stribeck, step)
        force = across / np.sqrt(1.0 + rub.around**2)
        return (
            force, -force * rub.along, -r * force * rub.around,
            force * rub.by_along, r * force * rub.mixed, r * r * force * rub.by_around,
        )  # fmt: skip

    return distributed_load, side_friction


distributed_load, side_friction = bind()
distributed_load_arctan, side_friction_arctan = bind(arctan=True)
distributed_load_sliding, side_friction_sliding = bind(sliding=True)
distributed_load_arctan_sliding, side_friction_arctan_sliding = bind(arctan=True, sliding=True)
distributed_load_stribeck, side_friction_stribeck = bind(stribeck=True)
distributed_load_arctan_stribeck, side_friction_arctan_stribeck = bind(arctan=True, stribeck=True)
distributed_load_step, side_friction_step = bind(step=True)
