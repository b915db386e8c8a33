# SPDX-License-Identifier: Apache-2.0
"""Top drive: prescribed speed, speed controller, or impedance control."""

import math
from collections.abc import Iterator
from typing import Annotated, Literal, NamedTuple

from drill_twin.core.units import Dimensionless, Inertia, OrAuto, Quantity, RotationalDamping, Torque, Within
from drill_twin.core.units.dimension import ROTATIONAL_DAMPING, ROTATIONAL_STIFFNESS
from drill_twin.physics.effects.config import Part, Problem

SLOWER = 10.0
"""First torsional frequency of the string over the corner frequency of the integral part tuned by `auto`."""
STIFF = 50.0
"""Impedance of a drive that spins up, over the string's; chosen, not measured: 0.96 of a wave comes back."""


class Tuning(NamedTuple):
    """Gains of the motor [N m s/rad], [N m/rad], and how it spins up."""

    proportional: float = 0.0
    integral: float = 0.0
    spin_up: tuple[float, float] = (0.0, 0.0)
    """Gains while the set-point changes and until its speed is reached."""
    wait: float = 0.0
    """Time near the set-point after which the gains of the spin-up end [s]; 0: the drive has none."""
    cancelled: float = 0.0
    """Inertia that the motor makes unfelt without them [kg m^2]."""


class TopDrive(Part):
    """Model of the top drive; its command is `rig.rotation`."""

    model: Literal["prescribed", "speed_controller", "impedance"] = "prescribed"
    """`prescribed`: rotates as commanded at any torque; `speed_controller`: motor torque proportional + integral in the
    error of speed; `impedance`: the same, tuned to absorb torsional waves (soft torque), after a spin-up with stiff
    gains until the speed is within 10 % of a steady set-point for a period of the string."""
    inertia: Annotated[Inertia, Within(at_least="0 kg m^2", at_most="1e6 kg m^2", reason="top drives have 1e3")] = 0.0
    """Moment of inertia of drive and motor about the string's axis [kg m^2]."""
    damping: Annotated[RotationalDamping, Within(at_least="0 N m s/rad", at_most="1e9 N m s/rad")] = 0.0
    """Viscous friction of bearings and gears [N m s/rad]."""
    torque_limit: Annotated[Torque, Within(above="0 N m", at_most="1e9 N m")] | None = None
    """Largest torque of the motor [N m]; unlimited if left out."""
    proportional_gain: Annotated[
        float | Literal["auto"],
        Quantity(ROTATIONAL_DAMPING),
        Within(at_least="0 N m s/rad", at_most="1e12 N m s/rad", reason="above, the turn is as good as prescribed"),
        OrAuto(),
    ] = "auto"
    """Motor torque per error of speed [N m s/rad]; `auto` (for `impedance` only): from `reflection`."""
    integral_gain: Annotated[
        float | Literal["auto"],
        Quantity(ROTATIONAL_STIFFNESS),
        Within(at_least="0 N m/rad", at_most="1e12 N m/rad", reason="above, the turn is as good as prescribed"),
        OrAuto(),
    ] = "auto"
    """Motor torque per error of angle [N m/rad]; with 0 N m/rad the speed droops under torque. `auto` (for `impedance`
    only): takes away the reactance of the felt inertia at the string's first torsional frequency, and controls the
    speed up to a tenth of it. With a gain of its own the drive has no spin-up."""
    reflection: Annotated[Dimensionless, Within(above="-1", below="1", reason="-1 is a held top, 1 a free one")] = 0.0
    """Reflection coefficient of torsional waves at the top, for their velocity [-]; with `impedance` and gains of
    `auto`, at the first frequency, and above it as far as the inertia is cancelled."""
    cancelled_inertia: Annotated[Dimensionless, Within(at_least="0", at_most="0.99")] = 0.9
    """Share of the inertia that the motor of `impedance` makes unfelt once it is soft, by a torque in proportion to the
    acceleration [-]; chosen, not measured: the motor of a rig does so with a delay, and this one without."""

    def problems(self) -> Iterator[Problem]:
        """Keys that the model does not use, and gains that it does not tune."""
        unused: tuple[str, ...] = ()
        if self.model == "prescribed":
            unused = (
                "inertia", "damping", "torque_limit", "proportional_gain", "integral_gain", "reflection",
                "cancelled_inertia",
            )  # fmt: skip
        elif self.model == "speed_controller":
            unused = ("reflection", "cancelled_inertia")
        elif self.proportional_gain != "auto":
            unused = ("reflection",)
        for key in unused:
            if key in self.model_fields_set and getattr(self, key) != type(self).model_fields[key].default:
                why = " and a `proportional_gain` of its own" if self.model == "impedance" else ""
                yield (key,), f'expected no `{key}` with model "{self.model}"{why}, found one'
        for key in ("proportional_gain", "integral_gain"):
            if self.model == "speed_controller" and getattr(self, key) == "auto":
                yield (key,), 'expected a number with model "speed_controller", found "auto": only "impedance" tunes'

    def tuning(self, impedance: float, frequency: float) -> Tuning:
        """Gains of the motor for a string.

        A drive of impedance Z at the end of a line of impedance Z_0 reflects r = (Z_0 - Z) / (Z_0 + Z) of a wave's
        velocity (transmission line theory; for drillstrings Halsey, Kyllingstad and Kylling 1988), hence
        Z = Z_0 (1 - r) / (1 + r). At the first frequency w the integral part J w^2 takes away the reactance of the
        felt inertia J (SoftSpeed, Kyllingstad and Nessjoen 2009), and above it the share of J that is cancelled does
        (Z-torque, Runia, Dwars and Stulemeijer 2013). The gains of the spin-up make the drive alone critically damped
        or more: P = 50 Z_0 + 2 J w and I = P w / 2 give P^2 >= 4 I J; chosen.

        Args:
            impedance: Z_0 = J sqrt(G rho) of the string at the top [N m s/rad].
            frequency: First torsional frequency of the string, held at the top [rad/s].
        """
        if self.model == "prescribed":
            return Tuning()
        tuned = impedance * (1.0 - self.reflection) / (1.0 + self.reflection)
        proportional = tuned if self.proportional_gain == "auto" else float(self.proportional_gain)
        cancelled = self.cancelled_inertia * self.inertia if self.model == "impedance" else 0.0
        if self.integral_gain != "auto":
            return Tuning(proportional, float(self.integral_gain), cancelled=cancelled)
        integral = (self.inertia - cancelled) * frequency**2 + proportional * frequency / SLOWER
        if self.proportional_gain != "auto":
            return Tuning(proportional, integral, cancelled=cancelled)
        stiff = STIFF * impedance + 2.0 * self.inertia * frequency
        return Tuning(proportional, integral, (stiff, 0.5 * stiff * frequency), math.tau / frequency, cancelled)
