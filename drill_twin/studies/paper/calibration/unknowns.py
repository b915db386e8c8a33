# SPDX-License-Identifier: Apache-2.0
"""What the paper leaves open, the bounds within which it is sought, and why these bounds."""

from __future__ import annotations

import math
from dataclasses import dataclass

from drill_twin.errors import SceneError
from drill_twin.scene import Scene
from drill_twin.studies.paper.runs.cases import DAMPING, changed, value_at


@dataclass(frozen=True)
class Unknown:
    """One number that is sought on a logarithmic scale."""

    place: str
    """Its place in the scene."""
    name: str
    """In words."""
    unit: str
    """Unit in which it is shown."""
    scale: float
    """SI units in one `unit`."""
    low: float
    """Least value sought [unit]."""
    high: float
    """Largest [unit]."""
    off: float | None
    """Value that stands for leaving it out [unit]; None where that has no meaning."""
    reason: str
    """Why these bounds."""
    also: tuple[str, ...] = ()
    """Other places that take the same value."""

    def value(self, share: float) -> float:
        """The value [SI] at a share, 0 to 1, of the way between the bounds."""
        return self.scale * self.low * math.exp(share * math.log(self.high / self.low))

    def share(self, value: float) -> float:
        """How far between the bounds a value [SI] lies, held within 0 and 1."""
        inside = min(max(value / self.scale, self.low), self.high)
        return math.log(inside / self.low) / math.log(self.high / self.low)


UNKNOWNS = (
    Unknown("rig.weight_on_bit.duration", "ramp of the weight on bit", "s", 1.0, 6.0, 15.0, None,
            "the critical times, 0.89 to 7.24 s, must lie on it: none of them is a whole multiple of the others' load"),
    Unknown("rig.rotation.duration", "ramp of the rotation", "s", 1.0, 0.3, 14.0, None,
            "an inverter starts in a fraction of a second; a STEP may last as long as that of the load"),
    Unknown("effects.bow.amplitude", "bow", "mm", 1e-3, 0.01, 3.0, 0.0,
            "from a rod that is straight to the eye to one that hung on two supports"),
    Unknown("effects.eccentricity.offset", "eccentricity", "mm", 1e-3, 0.01, 1.0, 0.0,
            "from a turned rod to an eighth of the radius"),
    Unknown(DAMPING[0], "retardation time of the material", "ms", 1e-3, 5.0, 50.0, 0.0,
            "loss factor of polyamide, 0.03 to 0.3 at 1 Hz, dry to damp; stretch and twist are of the same material",
            DAMPING[1:]),
    Unknown("effects.drag.linear", "drag", "N s/m^2", 1.0, 0.002, 0.1, 0.0,
            "air at 0.1 to 2 m/s on a round rod, 0.001 to 0.02; more where the bench rubs"),
    Unknown("effects.wall_friction.coefficient", "friction at the wall", "", 1.0, 0.02, 0.6, 0.0,
            "polyamide on steel or glass, oiled to dry"),
    Unknown("effects.wall_friction.decay", "fall of friction with slip", "s/m", 1.0, 0.01, 20.0, 0.0,
            "from Coulomb to a film that carries at 0.1 m/s; the delta of the paper's Eq. 10"),
    Unknown("effects.bit_friction.coefficient", "friction at the bit", "", 1.0, 0.003, 0.5, 0.0,
            "from a ball to a flat end on rock"),
    Unknown("effects.bit_friction.radius", "radius at which the bit rubs", "mm", 1e-3, 2.0, 8.2, None,
            "from a tip to the rim of the rod"),
)  # fmt: skip
"""The numbers sought. The paper's own numbers, and what stands fixed in the scene, are not among them."""


def shares_of(scene: Scene) -> list[float]:
    """Where the scene's own numbers lie between the bounds.

    Raises:
        SceneError: The scene leaves out an effect whose numbers are sought.
    """
    for unknown in UNKNOWNS:
        for place in (unknown.place, *unknown.also):
            part = place.rpartition(".")[0]
            if value_at(scene, part) is None:
                raise SceneError(f"{scene.name}: expected `{part}`, for its {unknown.name} is sought, found none")
    return [unknown.share(float(value_at(scene, unknown.place))) for unknown in UNKNOWNS]


def with_shares(scene: Scene, shares: list[float]) -> Scene:
    """The scene with the numbers that lie there."""
    for unknown, share in zip(UNKNOWNS, shares, strict=True):
        for place in (unknown.place, *unknown.also):
            scene = changed(scene, place, unknown.value(float(share)))
    return scene
