# SPDX-License-Identifier: Apache-2.0
"""Outputs asked for, and what gathers one of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from drill_twin.dynamics.twin.frame_record import FrameSeries, RigSeries
from drill_twin.dynamics.twin.twin import Twin


@dataclass(frozen=True)
class Request:
    """Outputs asked for, the same for all members.

    Attributes:
        names: Names of the outputs, of `OUTPUTS`.
        period: Length of a frame [s].
        frames: Frames of a run.
        every: Frames from one sample of the marks to the next.
    """

    names: tuple[str, ...]
    period: float
    frames: int
    every: int


class Variable(NamedTuple):
    """Value of one member."""

    value: Any
    dimensions: tuple[str, ...]
    unit: str


class Collector:
    """Gathers one output of a member."""

    def __init__(self, twin: Twin, request: Request) -> None:
        """Begin with the first frame."""
        self.twin, self.request = twin, request

    def add(self, rows: FrameSeries, rig: RigSeries) -> None:
        """Add the next frames."""

    def close(self) -> Mapping[str, Variable]:
        """Values of the whole run, by name."""
        raise NotImplementedError
