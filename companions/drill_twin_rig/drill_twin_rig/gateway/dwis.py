# SPDX-License-Identifier: Apache-2.0
"""Vocabulary of D-WIS (repository DDHub-Semantic-Interoperability), as far as a drillstring in its hole uses it.

A signal of D-WIS is a variable (`DynamicDrillingSignal`) and a data point that has it as its value. Facts on the two
are references: to a class or a quantity of the vocabulary itself, to anything else by a node that belongs to its class.
Whirl and lateral vibration have features and incidents in D-WIS, and no prototypes of signals: the prototypes of
`PROPOSED` are ours, and stand in a namespace of ours.
"""

from collections.abc import Iterator, Mapping
from typing import NamedTuple

NAMESPACE = "http://ddhub.no/"
"""Namespace of the vocabulary."""
PROPOSED_NAMESPACE = "urn:drill_twin:proposed"
"""Namespace of the classes that this package proposes."""

TOP, BOTTOM = "TopOfStringReferenceLocation", "BottomOfStringReferenceLocation"
LATERAL, WHIRLING = "DrillStemLateralVibrationFeature", "DrillStemWhirlingFeature"
PARENTS: Mapping[str, str] = {
    WHIRLING: LATERAL,
    "Whirling": "AbnormalLateralOscillation",
    **{f"DrillStem{kind}WhirlingFeature": WHIRLING for kind in ("Forward", "Backward", "Chaotic")},
    **{f"{kind}Whirl": "Whirling" for kind in ("Forward", "Backward", "Chaotic")},
}
"""Parent classes in the vocabulary: who asks for lateral vibration finds whirl."""
UNITS_OF_NODES: Mapping[str, tuple[str, str]] = {
    "simulator": ("Simulator", LATERAL),
    "analyzer": ("ComputationUnit", WHIRLING),
    "advisor": ("Advisor", WHIRLING),
}
"""Class of the computation unit that each node is, and the feature that it accounts for."""
TO_CLASSES = ("BelongsToClass", "IsOfMeasurableQuantity", "HasUnitOfMeasure")
"""Verbs whose object is a noun of the vocabulary itself."""
VERBS = (
    *TO_CLASSES, "AccountsFor", "HasDynamicValue", "IsComputedBy", "IsPhysicallyLocatedAt",
    "IsRelatedToDrillingIncident", "IsRelatedToDrillingLimit",
)  # fmt: skip
"""Verbs of the vocabulary that are used."""


class Prototype(NamedTuple):
    """Class of a signal."""

    quantity: str
    """Measurable quantity, a noun of the vocabulary."""
    location: str = ""
    """Reference location, a noun of the vocabulary."""
    incident: str = ""
    """Drilling incident that it is related to, a noun of the vocabulary."""
    feature: str = ""
    """Drilling management feature that it accounts for, a noun of the vocabulary."""


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
    "DownholeLateralAcceleration": Prototype(
        "AccelerationDrillingQuantity", BOTTOM, "AbnormalLateralOscillation", LATERAL
    ),
    "WallContactForce": Prototype("ForceDrillingQuantity", BOTTOM, "AbnormalLateralOscillation", LATERAL),
    **{
        f"Whirl{name}": Prototype(quantity, BOTTOM, "Whirling", WHIRLING)
        for name, quantity in {
            "Confidence": "ProportionStandardQuantity",
            "Detected": "DimensionLessStandardQuantity",
            "OnsetTime": "TimeQuantity",
            "OrbitRadius": "LengthSmallQuantity",
            "RPM": "RotationalFrequencyQuantity",
            "Ratio": "DimensionLessStandardQuantity",
            "Severity": "DimensionLessStandardQuantity",
            "State": "DimensionLessStandardQuantity",
        }.items()
    },
    **{
        f"{kind}WhirlDetected": Prototype(
            "DimensionLessStandardQuantity", BOTTOM, f"{kind}Whirl", f"DrillStem{kind}WhirlingFeature"
        )
        for kind in ("Forward", "Backward", "Chaotic")
    },
}
"""Classes that D-WIS lacks, by the names that this package proposes; precession is positive forward."""
ADVICE: Mapping[str, tuple[str, str]] = {
    "advised_weight_on_bit": ("AdvisedTarget", ""),
    "advised_rotation": ("AdvisedTarget", ""),
    "safe_weight_low": ("AdvisedMinimum", "WOBLimit"),
    "safe_weight_high": ("AdvisedMaximum", "WOBLimit"),
    "safe_rotation_low": ("AdvisedMinimum", "RotationalVelocityLimit"),
    "safe_rotation_high": ("AdvisedMaximum", "RotationalVelocityLimit"),
}
"""Class of the data points of advice, by quantity, and the drilling limit that they are related to."""


def classes(noun: str) -> Iterator[str]:
    """Noun and its parents in the vocabulary, as far as they are used."""
    while noun:
        yield noun
        noun = PARENTS.get(noun, "")


def facts(kind: str, quantity: str) -> Iterator[tuple[str, str]]:
    """Verb and noun of each fact on the data point of a signal, but for the class `kind` itself.

    Args:
        kind: Class of the signal.
        quantity: Quantity of the twin that it shows.
    """
    known = (PROTOTYPES | PROPOSED).get(kind, Prototype(""))
    nature, limit = ADVICE.get(quantity, ("ComputedData", ""))
    found = {
        "BelongsToClass": nature,
        "IsOfMeasurableQuantity": known.quantity,
        "IsPhysicallyLocatedAt": known.location,
        "IsRelatedToDrillingIncident": known.incident,
        "IsRelatedToDrillingLimit": limit,
        "AccountsFor": WHIRLING if quantity in ADVICE else known.feature,
    }
    yield from ((verb, noun) for verb, noun in found.items() if noun)


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
