# SPDX-License-Identifier: Apache-2.0
"""Top drive: prescribed speed, speed controller, or impedance control."""

import math
from collections.abc import Iterator
from typing import Annotated, Literal

from drill_twin.core.units import Dimensionless, Inertia, Quantity, RotationalDamping, Torque, Within
from drill_twin.core.units.dimension import ROTATIONAL_DAMPING, ROTATIONAL_STIFFNESS
from drill_twin.scene.blocks.part import OrAuto, Part, Problem

SLOWER = 10.0
"""First torsional frequency of the string over the corner frequency of the integral part tuned by `auto`."""


class TopDrive(Part):
    """Model of the top drive; its command is `rig.rotation`."""

    model: Literal["prescribed", "speed_controller", "impedance"] = "prescribed"
    """`prescribed`: rotates as commanded at any torque; `speed_controller`: motor torque proportional + integral in the
    error of speed; `impedance`: the same, tuned to absorb torsional waves (soft torque)."""
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
    only): speed is controlled up to a tenth of the string's first torsional frequency."""
    reflection: Annotated[Dimensionless, Within(above="-1", below="1", reason="-1 is a held top, 1 a free one")] = 0.0
    """Reflection coefficient of torsional waves at the top, for their velocity [-]; with `impedance` and gains of
    `auto`."""

    def problems(self) -> Iterator[Problem]:
        """Keys that the model does not use, and gains that it does not tune."""
        unused: tuple[str, ...] = ()
        if self.model == "prescribed":
            unused = ("inertia", "damping", "torque_limit", "proportional_gain", "integral_gain", "reflection")
        elif self.model == "speed_controller" or self.proportional_gain != "auto":
            unused = ("reflection",)
        for key in unused:
            if key in self.model_fields_set and getattr(self, key) != type(self).model_fields[key].default:
                why = " and a `proportional_gain` of its own" if self.model == "impedance" else ""
                yield (key,), f'expected no `{key}` with model "{self.model}"{why}, found one'
        for key in ("proportional_gain", "integral_gain"):
            if self.model == "speed_controller" and getattr(self, key) == "auto":
                yield (key,), 'expected a number with model "speed_controller", found "auto": only "impedance" tunes'

    def gains(self, impedance: float, delay: float) -> tuple[float, float]:
        """Proportional [N m s/rad] and integral gain [N m/rad] of the motor.

        A drive of impedance Z at the end of a line of impedance Z_0 reflects r = (Z_0 - Z) / (Z_0 + Z) of a wave's
        velocity (transmission line theory; for drillstrings Halsey, Kyllingstad and Kylling 1988), hence
        Z = Z_0 (1 - r) / (1 + r).

        Args:
            impedance: Z_0 = J sqrt(G rho) of the string at the top [N m s/rad].
            delay: Time of a torsional wave from top to bit [s]; the first frequency is a quarter of its inverse.
        """
        if self.model == "prescribed":
            return 0.0, 0.0
        tuned = impedance * (1.0 - self.reflection) / (1.0 + self.reflection)
        proportional = tuned if self.proportional_gain == "auto" else float(self.proportional_gain)
        slow = math.tau / (4.0 * delay) / SLOWER
        integral = proportional * slow if self.integral_gain == "auto" else float(self.integral_gain)
        return proportional, integral
