# SPDX-License-Identifier: Apache-2.0
"""Parameters that the paper does not give, their bounds, and the reasons of the bounds."""

from __future__ import annotations

import math
from dataclasses import dataclass

from drill_twin.core.errors import SceneError
from drill_twin.scene import Scene
from drill_twin_evidence.paper.runs.cases import DAMPING, changed, value_at


@dataclass(frozen=True)
class FreeParameter:
    """A parameter to calibrate, on a logarithmic scale."""

    place: str
    """Key in the scene."""
    name: str
    """Name in tables."""
    unit: str
    """Unit in tables."""
    scale: float
    """Value of one `unit` in SI."""
    low: float
    """Lower bound [unit]."""
    high: float
    """Upper bound [unit]."""
    reason: str
    """Reason of the bounds."""
    also: tuple[str, ...] = ()
    """Other keys with the same value."""

    def value(self, share: float) -> float:
        """The value [SI] at a share, 0 to 1, of the way between the bounds."""
        return self.scale * self.low * math.exp(share * math.log(self.high / self.low))

    def share(self, value: float) -> float:
        """Position of a value [SI] between the bounds, clipped to 0 to 1."""
        inside = min(max(value / self.scale, self.low), self.high)
        return math.log(inside / self.low) / math.log(self.high / self.low)


PARAMETERS = (
    FreeParameter("rig.weight_on_bit.duration", "ramp of the weight on bit", "s", 1.0, 6.0, 15.0,
            "the critical times, 0.89 to 7.24 s, must lie on it: none of them is a whole multiple of the others' load"),
    FreeParameter("rig.rotation.duration", "ramp of the rotation", "s", 1.0, 0.3, 14.0,
            "an inverter starts in a fraction of a second; a STEP may last as long as that of the load"),
    FreeParameter("effects.bow.amplitude", "bow", "mm", 1e-3, 0.01, 3.0,
            "from a rod that is straight to the eye to one that hung on two supports"),
    FreeParameter("effects.eccentricity.offset", "eccentricity", "mm", 1e-3, 0.01, 1.0,
            "from a turned rod to an eighth of the radius"),
    FreeParameter(DAMPING[0], "retardation time of the material", "ms", 1e-3, 5.0, 50.0,
            "loss factor of polyamide, 0.03 to 0.3 at 1 Hz, dry to damp; stretch and twist are of the same material",
            DAMPING[1:]),
    FreeParameter("effects.drag.linear", "drag", "N s/m^2", 1.0, 0.002, 0.1,
            "air at 0.1 to 2 m/s on a round rod, 0.001 to 0.02; more where the bench rubs"),
    FreeParameter("effects.wall_friction.coefficient", "friction at the wall", "", 1.0, 0.02, 0.6,
            "polyamide on steel or glass, oiled to dry"),
    FreeParameter("effects.wall_friction.decay", "fall of friction with slip", "s/m", 1.0, 0.01, 20.0,
            "from Coulomb to a film that carries at 0.1 m/s; the delta of the paper's Eq. 10"),
    FreeParameter("effects.bit_friction.coefficient", "friction at the bit", "", 1.0, 0.003, 0.5,
            "from a ball to a flat end on rock"),
    FreeParameter("effects.bit_friction.radius", "radius at which the bit rubs", "mm", 1e-3, 2.0, 8.2,
            "from a tip to the rim of the rod"),
)  # fmt: skip
"""Parameters to calibrate; the numbers of the paper are not among them."""


def shares_of(scene: Scene) -> list[float]:
    """Positions of the values of a scene between the bounds.

    Raises:
        SceneError: The scene lacks an effect whose parameters are calibrated.
    """
    for parameter in PARAMETERS:
        for place in (parameter.place, *parameter.also):
            part = place.rpartition(".")[0]
            if value_at(scene, part) is None:
                raise SceneError(f"{scene.name}: expected `{part}`, whose {parameter.name} is calibrated, found none")
    return [parameter.share(float(value_at(scene, parameter.place))) for parameter in PARAMETERS]


def with_shares(scene: Scene, shares: list[float]) -> Scene:
    """The scene with the parameters at these positions between the bounds."""
    for parameter, share in zip(PARAMETERS, shares, strict=True):
        for place in (parameter.place, *parameter.also):
            scene = changed(scene, place, parameter.value(float(share)))
    return scene
