# SPDX-License-Identifier: Apache-2.0
"""The `numerics:` part of a scene: resolution, tolerance, frame rate, seed, audit."""

from collections.abc import Iterator
from typing import Annotated, Literal

from drill_twin.core.units import Dimensionless, Frequency, OrAuto, Quantity, Whole, Within
from drill_twin.core.units.dimension import DIMENSIONLESS, LENGTH, TIME
from drill_twin.physics.effects.config import Part, Problem, Seed

_NANOSECONDS = 1_000_000_000


def frame_period_ns(rate: float) -> int:
    """Length of a frame [ns] at a frame rate [Hz]: whole, as stamps are, so that run, nodes and bag share every bit."""
    return round(_NANOSECONDS / rate)


def frame_period(rate: float) -> float:
    """As `frame_period_ns`, in seconds."""
    return frame_period_ns(rate) / _NANOSECONDS


FEWEST_ELEMENTS, MOST_ELEMENTS = 4, 4000


class Numerics(Part):
    """Resolution in space and time; `auto` is chosen by the twin."""

    elements: Annotated[
        int | Literal["auto"], Whole(FEWEST_ELEMENTS, MOST_ELEMENTS, 'a number of elements, or "auto",'), OrAuto()
    ] = "auto"
    """Number of elements of the string."""
    step: Annotated[float | Literal["auto"], Quantity(TIME), Within(at_least="1 ns", at_most="0.1 s"), OrAuto()] = (
        "auto"
    )
    """Time step [s]; at most the frame interval."""
    tolerance: Annotated[
        float | Literal["auto"], Quantity(DIMENSIONLESS), Within(at_least="1e-10", at_most="1e-3"), OrAuto()
    ] = "auto"
    """Newton's method stops at changes below this share of the string's smallest radius, less on a stiff wall, and of a
    radian [-]; `auto`: 1e-5, and 1e-6 where no effect dissipates, since the iteration error then accumulates."""
    accuracy: Annotated[Dimensionless, Within(at_least="1e-6", at_most="0.5")] | None = None
    """Instead of elements and step: largest error of the marks' paths before the onset of whirl and of the onset time
    [-], as "1 %"; `drill-twin run` and the simulator choose both from a cost curve (docs/accuracy.md)."""
    frame_rate: Annotated[Frequency, Within(at_least="1 Hz", at_most="2000 Hz")] = 100.0
    """Frames published per second of simulated time [Hz]."""
    seed: Seed = 1
    """Seed of everything random."""
    processor_time: Annotated[float, Quantity(TIME), Within(at_least="1 ms", at_most="1e6 s")] | None = None
    """Most processor time of a frame, after which the run ends with the reason [s]; 60 s unless given."""
    scheme: Literal["midpoint"] = "midpoint"
    """Time scheme."""
    lateral_from: Annotated[
        float | Literal["auto"], Quantity(LENGTH), Within(at_least="0 m", at_most="20 km"), OrAuto()
    ] = 0.0
    """Measured depth from which on the string moves laterally too [m]; above, the string follows the hole, stretches
    and twists. 0 m: the whole string moves; `auto`: the assembly and pipe that may buckle (docs/accuracy.md)."""
    audit: Literal["none", "energy"] = "none"
    """`energy`: energy balance with the work of each effect, published with the diagnostics; takes as much time as
    about two more Newton iterations a step."""

    @property
    def frame_period(self) -> float:
        """Length of a frame [s]."""
        return frame_period(self.frame_rate)

    @property
    def frame_period_ns(self) -> int:
        """Length of a frame [ns]."""
        return frame_period_ns(self.frame_rate)

    def problems(self) -> Iterator[Problem]:
        """Values that `accuracy` chooses itself, and a step beyond a frame."""
        for key in ("elements", "step", "tolerance"):
            if self.accuracy is not None and getattr(self, key) != "auto":
                yield (key,), f'expected "auto" with an `accuracy`, which chooses it, found {getattr(self, key)}'
        if self.step != "auto" and self.step * self.frame_rate > 1.0 + 1e-9:
            text = f"expected at most the time between frames ({1.0 / self.frame_rate:.6g} s), found {self.step:.6g} s"
            yield ("step",), text
