# SPDX-License-Identifier: Apache-2.0
"""Marks whose motion is analysed: position on the string and radial clearance."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from drill_twin.core.arrays import Array, ComplexArray
from drill_twin.core.errors import DrillTwinError
from drill_twin.whirl.columns import Columns, columns


class AnalysisError(DrillTwinError):
    """Input that the whirl analysis cannot use."""


@dataclass(frozen=True)
class MarkInfo:
    """One mark on the string.

    Raises:
        AnalysisError: A value is not finite or out of its range.
    """

    name: str
    """Name of the mark, unique in the string."""
    distance_from_bit: float
    """Distance from the bit along the string [m]."""
    on: Literal["wall", "centre"]
    """`wall`: on the outer wall, so that it shows the spin; `centre`: on the centre line."""
    wall_offset: float
    """Outer radius of the string at the mark [m]: a wall mark's distance from the centre line, and the rolling
    radius of any mark; 0 where it is unknown."""
    clearance: float
    """Radial clearance: displacement of the centre line at which the string touches the wall [m]."""
    inclined: bool = False
    """True where the hole is inclined, so that the string falls to its low side first; unknown counts as not."""

    def __post_init__(self) -> None:
        for good, expected, found in (
            (self.on in {"wall", "centre"}, "on = 'wall' or 'centre'", self.on),
            (0.0 < self.clearance < math.inf, "a clearance above 0 m", self.clearance),
            (0.0 <= self.wall_offset < math.inf, "a wall offset of 0 m or more", self.wall_offset),
            (math.isfinite(self.distance_from_bit), "a finite distance from the bit", self.distance_from_bit),
        ):
            if not good:
                raise AnalysisError(f"mark {self.name}: expected {expected}, found {found!r}")

    @property
    def rolling_ratio(self) -> float:
        """Whirl ratio in pure rolling along the wall, -r_o / clearance (Johnson 1962; Jansen 1991)."""
        return -self.wall_offset / self.clearance


def centre_lines(marks: Sequence[MarkInfo], position: Array, spin: Array) -> ComplexArray:
    """Centre line z = x + i y at m marks [m], without the rotation of marks on the wall, shape (..., m).

    Args:
        marks: The marks.
        position: Marked points [m], shape (..., m, 3).
        spin: Spin at the marks [rad], shape (..., m).
    """
    offset = np.array([mark.wall_offset if mark.on == "wall" else 0.0 for mark in marks])
    turned = np.where(offset > 0.0, offset * np.exp(1j * spin), 0.0)
    return np.asarray(position[..., 0] + 1j * position[..., 1] - turned)


def mark_columns(marks: Sequence[MarkInfo]) -> Columns:
    """Numbers of m marks, in the types for which the analysis is compiled."""
    distances = [mark.distance_from_bit for mark in marks]
    return columns(
        "MarkArrays",
        len(marks),
        clearance=np.array([mark.clearance for mark in marks], float),  # [m]
        wall_offset=np.array([mark.wall_offset for mark in marks], float),  # outer radius of the string [m]
        wall_radius=np.array(
            [mark.wall_offset if mark.on == "wall" else 0.0 for mark in marks], float
        ),  # of the point [m]
        rolling_ratio=np.array([mark.rolling_ratio for mark in marks], float),
        inclined=np.array([mark.inclined for mark in marks], bool),
        levels=np.array([distances.index(level) for level in sorted(set(distances))], int),  # a mark at each distance
    )


def check_marks(marks: Sequence[MarkInfo]) -> tuple[MarkInfo, ...]:
    """Check that there is at least one mark and that their names differ; return them as a tuple.

    Raises:
        AnalysisError: No mark, or two of one name.
    """
    if not marks:
        raise AnalysisError("expected a mark to analyse, found none; give the scene's string a mark")
    names = [mark.name for mark in marks]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise AnalysisError(f"expected marks of different names, found {', '.join(twice)} more than once")
    return tuple(marks)
