# SPDX-License-Identifier: Apache-2.0
"""Physical dimensions in scene files, each with its SI unit and examples."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Dimension:
    """Physical dimension of a quantity."""

    name: str
    """Name in messages: `length`."""
    unit: str
    """SI unit of values: `m`."""
    examples: tuple[str, ...] = ()
    """Examples for messages and editors, the best first."""
    also: tuple[str, ...] = ()
    """Other units accepted for the dimension, such as `N m` for `N m/rad`."""
    converted: tuple[tuple[str, float], ...] = ()
    """SI units of another kind accepted for the dimension, each with its factor to the SI unit."""

    @property
    def article(self) -> str:
        """Name with its article: `an angle`."""
        return ("an " if self.name[0] in "aeiou" else "a ") + self.name

    @property
    def expected(self) -> str:
        """Expected value in messages: `a length such as "16.5 mm"`."""
        return f'{self.article} such as "{self.examples[0]}"' if self.examples else self.article


GRAVITY = 9.80665
"""Standard gravity [m/s^2]: a pressure gradient over it is the density of a fluid."""

LENGTH = Dimension("length", "m", ("16.5 mm", "5 m", "12 1/4 in"))
MASS = Dimension("mass", "kg", ("2 kg", "5 lb"))
LINEAR_MASS = Dimension("mass per length", "kg/m", ("31 kg/m", "20.9 lb/ft"), (), (("N/m", 1.0 / GRAVITY),))
TIME = Dimension("time", "s", ("0.5 s", "4 ms", "2 min"))
FORCE = Dimension("force", "N", ("40 N", "160 kN", "36 klbf"))
ANGLE = Dimension("angle", "rad", ("30 deg", "0.5 rad"))
ANGULAR_SPEED = Dimension("speed of rotation", "rad/s", ("2 rev/s", "50 rpm", "5 rad/s"))
FREQUENCY = Dimension("frequency", "Hz", ("100 Hz",))
SPEED = Dimension("speed", "m/s", ("0.1 m/s",))
ACCELERATION = Dimension("acceleration", "m/s^2", ("9.81 m/s^2", "2 g"))
DENSITY = Dimension("density", "kg/m^3", ("1.10 g/cm^3", "7850 kg/m^3"), (), (("Pa/m", 1.0 / GRAVITY),))
PRESSURE = Dimension("pressure", "Pa", ("2.3 GPa", "210 GPa"))
TORQUE = Dimension("torque", "N m", ("12 N m",))
LINEAR_DRAG = Dimension("drag per length and speed", "N s/m^2", ("0.2 N s/m^2",))
ROTARY_DRAG = Dimension("rotary drag per length", "N m s/rad/m", ("0.001 N m s/rad/m",), also=("N s",))
HERTZ_STIFFNESS = Dimension("Hertz stiffness per length", "N/m^2.5", ("1e7 N/m^2.5",))
LINEAR_STIFFNESS = Dimension("stiffness per length", "N/m^2", ("1e6 N/m^2",))
INVERSE_SPEED = Dimension("inverse speed", "s/m", ("7 s/m",))
ROTATIONAL_STIFFNESS = Dimension("rotational stiffness", "N m/rad", ("50 N m/rad",), also=("N m",))
ROTATIONAL_DAMPING = Dimension("rotational damping", "N m s/rad", ("0.1 N m s/rad",), also=("N m s",))
UNBALANCE = Dimension("unbalance", "kg m", ("120 g mm",))
INERTIA = Dimension("moment of inertia", "kg m^2", ("2900 kg m^2",))
STIFFNESS = Dimension("stiffness", "N/m", ("25e6 N/m",))
DAMPING = Dimension("damping", "N s/m", ("1e4 N s/m",))
TIME_PER_ANGLE = Dimension("time per angle", "s/rad", ("1.91 s/rad",))
SQUARED_TIME_PER_ANGLE = Dimension("squared time per angle", "s^2/rad^2", ("5.47 s^2/rad^2",))
SPEED_PER_FORCE = Dimension("speed per force", "m/(N s)", ("5.672e-8 m/(N s)",))
LENGTH_PER_ANGLE = Dimension("length per angle", "m/rad", ("1.374e-4 m/rad",))
FORCE_TIMES_ANGLE = Dimension("force times angle", "N rad", ("9.537e6 N rad",))
FORCE_PER_LENGTH = Dimension("force per length", "N/m", ("2 N/m",))
CURVATURE = Dimension("curvature", "rad/m", ("3 deg/30 m", "3 deg/100 ft"))
VOLUME = Dimension("volume", "m^3", ("20 L", "10 bbl"))
VISCOSITY = Dimension("viscosity", "Pa s", ("0.02 Pa s", "20 cP"))
DIMENSIONLESS = Dimension("number without unit", "", ("0.3", "30 %"))

DIMENSIONS = tuple(value for value in tuple(globals().values()) if isinstance(value, Dimension))
"""All dimensions; where several share a unit, messages name the first."""
