# SPDX-License-Identifier: Apache-2.0
"""Quantities with units: text such as `"40 N"` in files, SI floats in memory; a field type for each dimension."""

from typing import Annotated

from drill_twin.core.units import dimension as dim
from drill_twin.core.units.dimension import Dimension
from drill_twin.core.units.parse import factor_of, parse, write
from drill_twin.core.units.quantity import OrAuto, Quantity, Whole, Within, refuse, show
from drill_twin.core.units.registry import UnitError

__all__ = [
    "Dimension", "OrAuto", "Quantity", "UnitError", "Whole", "Within", "factor_of", "parse", "refuse", "show", "write",
]  # fmt: skip

Length = Annotated[float, Quantity(dim.LENGTH)]
Mass = Annotated[float, Quantity(dim.MASS)]
LinearMass = Annotated[float, Quantity(dim.LINEAR_MASS)]
Time = Annotated[float, Quantity(dim.TIME)]
Force = Annotated[float, Quantity(dim.FORCE)]
Angle = Annotated[float, Quantity(dim.ANGLE)]
AngularSpeed = Annotated[float, Quantity(dim.ANGULAR_SPEED)]
Frequency = Annotated[float, Quantity(dim.FREQUENCY)]
Speed = Annotated[float, Quantity(dim.SPEED)]
Acceleration = Annotated[float, Quantity(dim.ACCELERATION)]
Density = Annotated[float, Quantity(dim.DENSITY)]
Pressure = Annotated[float, Quantity(dim.PRESSURE)]
Torque = Annotated[float, Quantity(dim.TORQUE)]
LinearDrag = Annotated[float, Quantity(dim.LINEAR_DRAG)]
RotaryDrag = Annotated[float, Quantity(dim.ROTARY_DRAG)]
HertzStiffness = Annotated[float, Quantity(dim.HERTZ_STIFFNESS)]
LinearStiffness = Annotated[float, Quantity(dim.LINEAR_STIFFNESS)]
InverseSpeed = Annotated[float, Quantity(dim.INVERSE_SPEED)]
RotationalStiffness = Annotated[float, Quantity(dim.ROTATIONAL_STIFFNESS)]
RotationalDamping = Annotated[float, Quantity(dim.ROTATIONAL_DAMPING)]
Inertia = Annotated[float, Quantity(dim.INERTIA)]
Unbalance = Annotated[float, Quantity(dim.UNBALANCE)]
Stiffness = Annotated[float, Quantity(dim.STIFFNESS)]
Damping = Annotated[float, Quantity(dim.DAMPING)]
TimePerAngle = Annotated[float, Quantity(dim.TIME_PER_ANGLE)]
SquaredTimePerAngle = Annotated[float, Quantity(dim.SQUARED_TIME_PER_ANGLE)]
SpeedPerForce = Annotated[float, Quantity(dim.SPEED_PER_FORCE)]
LengthPerAngle = Annotated[float, Quantity(dim.LENGTH_PER_ANGLE)]
ForceTimesAngle = Annotated[float, Quantity(dim.FORCE_TIMES_ANGLE)]
ForcePerLength = Annotated[float, Quantity(dim.FORCE_PER_LENGTH)]
Viscosity = Annotated[float, Quantity(dim.VISCOSITY)]
Dimensionless = Annotated[float, Quantity(dim.DIMENSIONLESS)]
