# SPDX-License-Identifier: Apache-2.0
"""Points of a comparison of whirl states with simulations, and their file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from drill_twin.core.files.json_files import JsonLines
from drill_twin.scene import Scene
from drill_twin_evidence.whirl_compare.motion import STEADY

ON_STATE, MODULATED, PAST_HOPF, TWO_COMPUTED, NO_STATE, COEXISTS, MISSED = (
    "a stable state", "a stable state, modulated", "modulated, about an unstable state", "two frequencies, computed",
    "no stable state", "beside a stable state", "no such state found",
)  # fmt: skip
ON_A_STATE = (ON_STATE, MODULATED, PAST_HOPF)
AGREES = (*ON_A_STATE, TWO_COMPUTED, NO_STATE)
"""Verdicts of points where tool and simulation agree."""
FORMAT = 4
"""Of the records."""


@dataclass(frozen=True)
class TwoFrequencies:
    """Computed whirl with two frequencies that a run is on."""

    ratio: float
    """Whirl speed of one part of the string over the rotation."""
    second: float
    """That of the other part."""
    growth: float
    """Of the fastest disturbance [1/s]; negative: all decay."""
    neutral: float
    """Distance from 1 of the two multipliers that are 1."""


@dataclass(frozen=True)
class Point:
    """One load and speed."""

    weight_on_bit: float
    """[N]."""
    rotation: float
    """[rad/s]."""
    motion: str
    """Kind of the simulated motion."""
    ratio: float
    """Its whirl speed over the rotation."""
    second: float | None
    """Second speed of a motion of two frequencies, over the rotation."""
    change: float | None
    """Change of its shape in the frame of the whirl, over the clearance."""
    states: tuple[tuple[float, float, float], ...]
    """Ratio, growth [1/s] and frequency in its frame [Hz] of each state found; of the axis with the ratio 0."""
    stable: tuple[float, ...]
    """Ratios of the stable ones on the wall."""
    verdict: str
    modulation: float | None = None
    """Change of the shape by bow and eccentricity, to first order, of the stable state that the motion is on."""
    duration: float = 0.0
    """Simulated time of the run [s]; longer than asked for where a state is slow to settle on."""
    searched: bool = True
    """False if the state that the motion is on was not found by the search, but from the run's shape."""
    two: TwoFrequencies | None = None
    """Whirl with two frequencies that Newton's method finds from the run, stable, with its speeds and radii."""
    held: tuple[tuple[float, bool], ...] = ()
    """Ratio of each stable state that the run from rest is not on, and whether a run begun on it stays."""

    @property
    def agrees(self) -> bool:
        """True if the simulated motion is what the states say."""
        return self.verdict in AGREES

    @property
    def reason(self) -> str:
        """Evidence for a verdict, as far as it was tested."""
        parts = [f"a run begun on {ratio:+.3f} {'stays' if stays else 'leaves'}" for ratio, stays in self.held]
        if self.two is not None:
            parts.insert(0, f"disturbances decay at {-self.two.growth:.2g} 1/s")
        if not self.searched:
            parts.insert(0, "missed by the search; found from the shape of the run")
        return "; ".join(parts)


def setup_of(scene: Scene, duration: float) -> dict[str, Any]:
    """All that the points depend on, in plain types."""
    return {"scene": scene.model_dump(mode="json", exclude_none=True), "duration": duration, "format": FORMAT}


def points_file(path: Path, setup: Mapping[str, Any]) -> JsonLines[Point]:
    """File of the points of a comparison.

    Raises:
        ArgumentError: The file holds points of another study, or something else.
        BagError: It cannot be read or written.
    """
    return JsonLines(path, Point, "whirl comparison", setup, remedy="take another file with --record")


def sentences(points: Sequence[Point]) -> list[str]:
    """Sentences on the number of explained points, by kind of explanation."""

    def count(*verdicts: str) -> int:
        return sum(point.verdict in verdicts for point in points)

    held = [[stays for _, stays in point.held] for point in points if point.held]
    explained = sum(point.agrees for point in points)
    found = (
        f"{explained} of {len(points)} points are explained: {count(*ON_A_STATE)} runs from the axis are on a stable "
        f"state or modulated about one, {count(TWO_COMPUTED)} in a computed whirl with two frequencies, and at "
        f"{count(NO_STATE)} points the motion is irregular and no stable state exists."
    )
    begun = f"At {len(held)} points runs began on other stable states: at {sum(map(all, held))} all of them stay."
    lines = [found, begun]
    whirls = [point for point in points if point.motion == STEADY and point.verdict == ON_STATE]
    if whirls:
        apart = max(min(abs(point.ratio / ratio - 1.0) for ratio in point.stable) for point in whirls)
        lines.append(f"Whirl speeds of the {len(whirls)} steady runs differ by {apart:.2%} at most.")
    shapes = [(point.change, point.change / point.modulation) for point in whirls if point.change and point.modulation]
    if shapes:
        (least, _), (most, _) = min(shapes), max(shapes)
        shares = [share for _, share in shapes]
        lines.append(f"Their shapes change by {least:.0e} to {most:.0e} of the clearance, {min(shares):.2f} to "
                     f"{max(shares):.2f} of the modulation by bow and eccentricity to first order.")  # fmt: skip
    twos = [(point, point.two) for point in points if point.two is not None]
    if twos:
        first = max(abs(point.ratio - two.ratio) for point, two in twos)
        second = max(abs(point.second - two.second) for point, two in twos if point.second is not None)
        lines.append(f"The speeds of both parts of the string differ from the computed ones by {first:.1e} and "
                     f"{second:.1e} of the rotation at most.")  # fmt: skip
    return lines
