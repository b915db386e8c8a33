# SPDX-License-Identifier: Apache-2.0
"""Dry friction torque of the bit that decreases with speed (Stribeck): the bit can stick and slip."""

import math
from collections.abc import Callable, Iterator
from typing import Annotated, Any, ClassVar, Literal, NamedTuple

import numpy as np
from pydantic import ConfigDict, model_validator

from drill_twin.core.arrays import Array
from drill_twin.core.compile.jit import kernel
from drill_twin.core.units import AngularSpeed, Dimensionless, Length, Pressure, TimePerAngle, Within, refuse, show
from drill_twin.physics.effects.config import EffectConfig, Problem
from drill_twin.physics.effects.friction_dual import dual_variable, no_iterate
from drill_twin.physics.model import SPIN, DiscreteModel, Rod
from drill_twin.physics.model.bit import BIT_TORQUE, DRILLED, apply_torque, contact_weight

NUMBERS = ("sliding", "sticking", "decay")
BITS = {
    kind: {"sliding": sliding, "sticking": sticking, "decay": "0.9 s/rad"}
    for kind, sliding, sticking in (
        ("pdc", 0.7, 1.12), ("roller_cone", 0.2, 0.25), ("hybrid", 0.45, 0.65), ("bicentre", 0.8, 1.28),
    )
}  # fmt: skip
"""Numbers of the law by type of bit, with their sources in the docstring of `BitTorqueStribeck`."""


def _needs_numbers_or_a_type(schema: dict[str, Any]) -> None:
    schema["required"] = ["radius"]
    schema["anyOf"] = [{"required": ["bit"]}, {"required": list(NUMBERS)}]


class BitTorqueStribeck(EffectConfig):
    """T = R W (mu_c + (mu_s - mu_c) exp(-gamma |w|)) against the bit's spin (Navarro-Lopez and Suarez 2004).

    With an `exponent` n, exp(-(gamma |w|)^n) (Armstrong-Helouvry, Dupont and Canudas de Wit 1994): the larger n, the
    nearer to a threshold at the speed 1 / gamma.

    With a `specific_energy` eps the bit drills: the work of the sliding part of its torque cuts the rock, at a rate of
    R W mu_c w / (A eps), with the area A of the bit of which R is 2/3 of the radius (Teale 1965); what sticking costs
    above that cuts nothing. The weight is set, so the string does not descend.

    Of a type of `bit`, mu_c is the coefficient of Pessier and Fear (1992), 36 T / (D W) in ft lbf, in and lbf, with R a
    third of the diameter D. Its ranges are of the literature, from general knowledge, fitted to nothing: `pdc` 0.5 to
    1, `roller_cone` 0.15 to 0.3, `hybrid` 0.3 to 0.6, `bicentre` 0.6 to 1.1. The law of Detournay and Defourny (1992)
    gives a PDC bit 0.45 where wear flats carry all and 1.25 where none do (`thrust` = `friction` = 0.6). gamma, and
    mu_s over mu_c of fixed cutters, are of Navarro-Lopez and Suarez (2004); the smaller falls of cones are chosen, not
    measured.
    """

    model_config = ConfigDict(json_schema_extra=_needs_numbers_or_a_type)
    requires: ClassVar[tuple[str, ...]] = ("stretch", "torsion")
    provides = ("torque",)
    energy_class = "heat"

    bit: Literal["pdc", "roller_cone", "hybrid", "bicentre"] | None = None
    """Type of bit: its `sliding`, `sticking` and `decay`, unless they are given, are for `pdc` 0.7, 1.12 and 0.9 s/rad,
    `roller_cone` 0.2, 0.25, 0.9, `hybrid` 0.45, 0.65, 0.9, `bicentre` 0.8, 1.28, 0.9."""
    radius: Annotated[Length, Within(above="0 m", at_most="2 m")]
    """Effective radius of friction, R [m]; a third of the bit's diameter for numbers of a type."""
    sliding: Annotated[Dimensionless, Within(at_least="0", at_most="5")]
    """Friction coefficient at high speed, mu_c [-]; required without `bit`, as the next two."""
    sticking: Annotated[Dimensionless, Within(at_least="0", at_most="5")]
    """Friction coefficient at rest, mu_s [-]; not below `sliding`."""
    decay: Annotated[TimePerAngle, Within(at_least="0 s/rad", at_most="1e4 s/rad")]
    """Decay of friction with speed, gamma [s/rad]."""
    exponent: Annotated[Dimensionless, Within(at_least="1", at_most="20")] | None = None
    """Exponent n of the decay [-]; left out: 1."""
    specific_energy: Annotated[Pressure, Within(above="0 Pa", at_most="1e11 Pa")] | None = None
    """Work of the bit per volume of rock, eps [Pa]; left out: the bit does not drill."""
    creep: Annotated[AngularSpeed, Within(at_least="1e-9 rad/s", at_most="0.1 rad/s")] = 1e-4
    """Speed of regularisation: a sticking bit creeps below it [rad/s]."""

    @model_validator(mode="before")
    @classmethod
    def _has_the_numbers_of_its_type(cls, data: Any) -> Any:
        if not isinstance(data, dict) or data.get("bit") is None:
            return data
        if (kind := str(data["bit"]).lower()) not in BITS:
            raise refuse(f"`bit`: expected a type, {', '.join(BITS)}, found {show(data['bit'])}")
        return BITS[kind] | data | {"bit": kind}

    def problems(self) -> Iterator[Problem]:
        """A bit that slides harder than it sticks."""
        if self.sticking < self.sliding:
            yield (), f"expected `sticking` not below `sliding` ({self.sliding:g}), found {show(self.sticking)}"

    @property
    def variant(self) -> str:
        """The law, by the names of its additions to the default law."""
        return "" if self.exponent is None else "exponent"


class Parameters(NamedTuple):
    """R [m], mu_c, mu_s, gamma [s], creep [rad/s], the last Newton iterate, the exponent of the decay, and the depth
    drilled per work of the sliding torque, 1 / (A eps) [1/N].
    """

    radius: float
    sliding: float
    sticking: float
    decay: float
    creep: float
    memory: Array  # see `no_iterate`
    exponent: float
    drilling: float


def parameters(block: BitTorqueStribeck, model: DiscreteModel) -> Parameters:
    """Parameters of the block, without an iterate."""
    area = math.pi * (1.5 * block.radius) ** 2
    drilling = 0.0 if block.specific_energy is None else 1.0 / (area * block.specific_energy)
    return Parameters(
        block.radius, block.sliding, block.sticking, block.decay, block.creep, no_iterate(), block.exponent or 1.0,
        drilling,
    )  # fmt: skip


@kernel
def dual_of_step(memory: Array, time: float, half_step: float, speed: float, size: float) -> float:
    """Dual variable of a speed: share of the friction limit, -1 to 1, from the last iterate (`friction_dual`).

    The last iterate counts where it is of the same step, or, at time 0, of the same instant.
    """
    same = memory[6] == time and (memory[7] == half_step or time == 0.0)
    share, _ = dual_variable(memory, not same, memory[5] + 1.0, speed, 0.0, size, 1.0)
    memory[6], memory[7] = time, half_step
    return float(share)


@kernel
def sign_missed(memory: Array, speed: float) -> float:
    """Difference of the regularised sign at a speed from its tangent in the last iteration, a share of the friction."""
    before, size, share = memory[0], memory[2], memory[3]
    tangent = (before + (1.0 - share * before / size) * (speed - before)) / size
    return float(abs(speed / np.sqrt(max(speed * speed + size * size - before * before, 1e-300)) - tangent))


@kernel
def missed(parameters: Any, v: Array) -> float:
    """Share of the friction by which it will change in the next iteration."""
    return float(sign_missed(parameters.bit_torque_stribeck.memory, v[0, SPIN]))


@kernel
def friction(law: Parameters, weight: float, speed: float) -> tuple[float, float, float]:
    """Friction limit at a speed [N m], its slope by the speed's size [N m s], and the smoothed size of the speed."""
    excess = (law.sticking - law.sliding) * np.exp(-law.decay * abs(speed))
    arm = law.radius * weight
    return arm * (law.sliding + excess), -arm * law.decay * excess, np.sqrt(speed * speed + law.creep * law.creep)


@kernel
def friction_exponent(law: Parameters, weight: float, speed: float) -> tuple[float, float, float]:
    """The same with an exponent of the decay."""
    size = np.sqrt(speed * speed + law.creep * law.creep)
    steep = (law.decay * size) ** law.exponent
    excess = (law.sticking - law.sliding) * np.exp(-steep)
    arm = law.radius * weight
    return arm * (law.sliding + excess), -arm * excess * law.exponent * steep / size, size


def bind(friction: Callable[..., tuple[float, float, float]]) -> tuple[Callable[..., None], Callable[..., None]]:
    """The load and the impulse for one law."""

    @kernel
    def end_load(
        parameters: Any,
        rod: Rod,
        command: Array,
        time: float,
        half_step: float,
        u: Array,
        v: Array,
        v_old: Array,
        ends: Array,
    ) -> None:
        """Add friction against the bit's spin, w / sqrt(w^2 + creep^2) of its limit."""
        law, bit, speed = parameters.bit_torque_stribeck, parameters.drive.bit, v[0, SPIN]
        limit, fall, size = friction(law, contact_weight(bit), speed)
        share = dual_of_step(law.memory, time, half_step, speed, size)
        slope = limit / size * (1.0 - share * speed / size) + fall * abs(speed) / size
        apply_torque(bit, (limit * speed / size, slope), ends)

    @kernel
    def after_step(parameters: Any, rod: Rod, command: Array, time: float, step: float, u: Array, v: Array) -> None:
        """Add the impulse of the torque in the step, and the depth that its work cuts."""
        law, bit, speed = parameters.bit_torque_stribeck, parameters.drive.bit, parameters.drive.bit.rate[SPIN]
        weight = contact_weight(bit)
        limit, _, size = friction(law, weight, speed)
        bit.impulse[BIT_TORQUE] -= step * limit * speed / size
        bit.impulse[DRILLED] += step * law.radius * weight * law.sliding * max(speed, 0.0) * law.drilling

    return end_load, after_step


end_load, after_step = bind(friction)
end_load_exponent, after_step_exponent = bind(friction_exponent)
