# SPDX-License-Identifier: Apache-2.0
"""The `hole:` part of a scene: straight or surveyed axis, radius by measured depth."""

import math
from collections.abc import Iterator
from typing import Annotated

import numpy as np
from pydantic import Field

from drill_twin.core.units import Angle, Length, Within
from drill_twin.physics.effects.config import Depth, DepthInterval, Part, Problem, out_of_order
from drill_twin.physics.model.survey import dogleg, survey

SHARPEST_BEND = 10.0
"""Smallest radius of curvature of the hole, in radii of the hole."""
LARGEST_TURN = math.radians(150.0)
"""Largest angle between the hole and its direction at the top, the reference of all directions [rad]."""


class Interval(DepthInterval):
    """Interval of the hole with a radius of its own: casing, washout, tight spot."""

    radius: Annotated[Length, Within(above="0 m", at_most="10 m")]
    """Radius in the interval [m]."""


class Station(Part):
    """Survey station."""

    depth: Depth
    """Measured depth from the top clamp [m]."""
    inclination: Annotated[Angle, Within(at_least="0 deg", at_most="180 deg")]
    """Angle of the hole from the vertical [rad]."""
    azimuth: Annotated[Angle, Within(at_least="-360 deg", at_most="360 deg")] = 0.0
    """Direction of the hole seen from above, clockwise from north [rad]."""


class Hole(Part):
    """The hole around the string."""

    radius: Annotated[Length, Within(above="0 m", at_most="10 m")]
    """Radius [m], outside of `intervals`."""
    inclination: Annotated[Angle, Within(at_least="0 deg", at_most="180 deg")] = 0.0
    """Angle of the axis of a straight hole from the vertical [rad]; the low side is +x. Not with `survey`."""
    intervals: Annotated[tuple[Interval, ...], Field(max_length=1000)] = ()
    """Intervals of another radius, from the top down."""
    survey: Annotated[tuple[Station, ...], Field(max_length=10_000)] = ()
    """Stations from the top clamp down, joined by circular arcs (minimum curvature); left out: a straight hole."""

    def problems(self) -> Iterator[Problem]:
        """Intervals that overlap; a survey that does not begin at the top, does not go down, or bends too much."""
        yield from out_of_order(self.intervals)
        if self.survey:
            yield from self._problems_of_survey()

    def _problems_of_survey(self) -> Iterator[Problem]:
        depth = self.stations[0]
        if self.inclination != 0.0:
            yield (
                ("inclination",),
                (
                    f"expected no `inclination` beside a `survey`, found {math.degrees(self.inclination):.6g} deg; "
                    "the survey defines it"
                ),
            )
        if depth[0] != 0.0:
            text = f"expected 0 m, the top clamp, at the first station, found {depth[0]:.6g} m"
            yield ("survey", 0, "depth"), text
        runs = np.diff(depth)
        if not runs.size:
            yield ("survey",), "expected at least two stations, found one"
        elif upwards := np.flatnonzero(runs <= 0.0).tolist():
            above = upwards[0]
            text = f"expected more than the station above it ({depth[above]:.6g} m), found {depth[above + 1]:.6g} m"
            yield ("survey", above + 1, "depth"), text
        else:
            yield from self._bends(runs)

    def _bends(self, runs: np.ndarray) -> Iterator[Problem]:
        """Yield the first bend that is too sharp, or else the largest turn away from the direction at the top."""
        depth, inclination, azimuth = self.stations
        sharpest = SHARPEST_BEND * max([self.radius, *(interval.radius for interval in self.intervals)])
        for index, (turn, run) in enumerate(zip(dogleg(inclination, azimuth), runs, strict=True), start=1):
            if turn > 0.5 * math.pi or turn * sharpest > run:
                most = min(0.5 * math.pi, run / sharpest)
                yield (
                    ("survey", index),
                    (
                        f"expected a turn of at most {math.degrees(most):.4g} deg since the station above (90 deg, and "
                        f"a bend of {SHARPEST_BEND:g} radii of the hole), found {math.degrees(turn):.4g} deg in "
                        f"{run:.6g} m"
                    ),
                )
                return
        ways = survey(depth, inclination, azimuth).down
        total = np.arccos(np.clip(ways @ ways[0], -1.0, 1.0))
        if total.max() > LARGEST_TURN:
            yield (
                ("survey", int(total.argmax())),
                (
                    f"expected a direction within {math.degrees(LARGEST_TURN):g} deg of that at the top, "
                    f"found {math.degrees(total.max()):.4g} deg"
                ),
            )

    @property
    def top_inclination(self) -> float:
        """Angle of the axis from the vertical at the top clamp [rad]."""
        return self.survey[0].inclination if self.survey else self.inclination

    @property
    def stations(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Measured depth [m], inclination [rad] and azimuth [rad] of the survey's stations."""
        rows = np.array([(s.depth, s.inclination, s.azimuth) for s in self.survey]).reshape(-1, 3)
        return rows[:, 0].copy(), rows[:, 1].copy(), rows[:, 2].copy()

    def least_radius(self, top: float, bottom: float) -> float:
        """Smallest radius between two measured depths [m]."""
        met = [i for i in self.intervals if i.top < bottom and i.bottom > top]
        covered = math.fsum(min(i.bottom, bottom) - max(i.top, top) for i in met)
        gaps = [self.radius] if covered < (bottom - top) * (1.0 - 1e-12) else []
        return min([self.radius_at(bottom), *gaps, *(i.radius for i in met)])

    def radius_at(self, depth: float) -> float:
        """Radius at a measured depth from the top clamp [m]; where two intervals meet, the radius of the lower one."""
        for interval in self.intervals:
            if interval.top <= depth < interval.bottom:
                return interval.radius
        return self.radius
