# SPDX-License-Identifier: Apache-2.0
"""Vocabulary of D-WIS (repository DDHub-Semantic-Interoperability), as far as a drillstring in its hole uses it.

A signal of D-WIS is a variable (`DynamicDrillingSignal`) and a data point that has it as its value; classes, quantity,
unit and location are references from the two to nodes of the vocabulary. D-WIS has no prototype for lateral vibration
and whirl: the prototypes of `PROPOSED` are ours, and stand in a namespace of ours.
"""

from __future__ import annotations

from typing import NamedTuple

NAMESPACE = "http://ddhub.no/"
"""Namespace of the vocabulary."""
PROPOSED_NAMESPACE = "urn:drill_twin:proposed"
"""Namespace of the classes that this package proposes."""

TOP, BOTTOM = "TopOfStringReferenceLocation", "BottomOfStringReferenceLocation"


class Prototype(NamedTuple):
    """Class of a signal."""

    quantity: str
    """Measurable quantity, a noun of the vocabulary."""
    location: str = ""
    """Reference location, a noun of the vocabulary."""
    incident: str = ""
    """Drilling incident that it is related to, a noun of the vocabulary."""


PROTOTYPES = {
    "WOB": Prototype("ForceDrillingQuantity", BOTTOM),
    "SurfaceRPM": Prototype("RotationalFrequencyQuantity", TOP),
    "SurfaceTorque": Prototype("TorqueDrillingQuantity", TOP),
    "DownholeRPM": Prototype("RotationalFrequencyQuantity", BOTTOM),
    "DownholeTorque": Prototype("TorqueDrillingQuantity", BOTTOM),
    "HookLoad": Prototype("ForceDrillingQuantity", TOP),
    "HookPosition": Prototype("PositionDrillingQuantity", TOP),
    "HookVelocity": Prototype("BlockVelocityDrillingQuantity", TOP),
    "TopOfStringPosition": Prototype("PositionDrillingQuantity", TOP),
    "BitDepth": Prototype("DepthDrillingQuantity", BOTTOM),
    "ROP": Prototype("RateOfPenetrationDrillingQuantity", BOTTOM),
    "DownholeAxialAcceleration": Prototype("AccelerationDrillingQuantity", BOTTOM),
    "DownholeAngularAcceleration": Prototype("AngularAccelerationDrillingQuantity", BOTTOM),
    "StickSlipSeverityIndex": Prototype("DimensionLessStandardQuantity", BOTTOM, "StickSlip"),
}
"""Prototypes of D-WIS that apply to the twin."""
PROPOSED = {
    "DownholeLateralAcceleration": Prototype("AccelerationDrillingQuantity", BOTTOM, "AbnormalLateralOscillation"),
    "WallContactForce": Prototype("ForceDrillingQuantity", BOTTOM, "AbnormalLateralOscillation"),
    "WhirlConfidence": Prototype("ProportionStandardQuantity", BOTTOM, "Whirling"),
    "WhirlDetected": Prototype("DimensionLessStandardQuantity", BOTTOM, "Whirling"),
    "WhirlOrbitRadius": Prototype("LengthSmallQuantity", BOTTOM, "Whirling"),
    "WhirlRatio": Prototype("DimensionLessStandardQuantity", BOTTOM, "Whirling"),
    "WhirlRPM": Prototype("RotationalFrequencyQuantity", BOTTOM, "Whirling"),
}
"""Classes that D-WIS lacks, by the names that this package proposes; precession is positive forward."""


class Unit(NamedTuple):
    """Unit as OPC UA and D-WIS name it."""

    noun: str
    """Noun of the vocabulary; empty: it has none."""
    code: str = ""
    """Code of UNECE recommendation 20; empty: it has none."""

    @property
    def number(self) -> int:
        """Number of the code in OPC UA (part 8, 5.6.3); -1 without one."""
        return int.from_bytes(self.code.encode("ascii"), "big") if self.code else -1


UNITS = {
    "N": Unit("Newton", "NEW"),
    "kN": Unit("Kilonewton", "B47"),
    "daN": Unit("Decanewton"),
    "kgf": Unit("KilogramForce", "B37"),
    "lbf": Unit("PoundForce", "C78"),
    "klbf": Unit("KilopoundForce"),
    "rpm": Unit("Rpm", "RPM"),
    "rev/s": Unit("RotationPerSecond", "RPS"),
    "rad/s": Unit("RadianPerSecond", "2A"),
    "N m": Unit("NewtonMetre", "NU"),
    "kN m": Unit("KilonewtonMetre", "B48"),
    "m": Unit("Metre", "MTR"),
    "mm": Unit("Millimetre", "MMT"),
    "ft": Unit("Foot", "FOT"),
    "in": Unit("Inch", "INH"),
    "m/s": Unit("MetrePerSecond", "MTS"),
    "m/h": Unit("MetrePerHour", "M60"),
    "ft/h": Unit("FootPerHour", "K14"),
    "m/s^2": Unit("MetrePerSecondSquared", "MSK"),
    "rad/s^2": Unit("RadianPerSecondSquared", "2B"),
    "s": Unit("Second", "SEC"),
    "": Unit("Dimensionless", "C62"),
}
"""Units with a noun of D-WIS, by their text in this package."""
