# SPDX-License-Identifier: Apache-2.0
"""Task for a tool, and the motion that it gives back."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
SCENES = Path(__file__).resolve().parent.parent / "scenes"

SMOOTH = {
    "wob": "0 N", "rpm": "0 rev/s", "duration": "1 s",
    "effects.gravity": "off", "effects.drag": "off", "effects.wall": "off", "effects.wall_friction": "off",
    "effects.lateral_kick.velocity": "0.3 m/s",
}  # fmt: skip
"""The pluck: no load, no gravity, no wall, nothing that brakes."""
ABOVE = SMOOTH | {"wob": "40 N", "duration": "0.8 s"}
"""The same, pushed to three times its buckling load within 0.2 s; mid-span swings out by metres. Soon after, the rod
folds back on itself, where drill_twin's unknowns are singular: it stops there, the peers do not."""
HARD = {"wob": "300 N", "rpm": "6.5 rev/s", "duration": "30 s"}
"""Fifteen times the buckling load, and 390 rpm."""


@dataclass(frozen=True)
class Task:
    """One run of one tool."""

    tool: str
    """A key of `drill_twin_evidence.benchmarks.peers.run.TOOLS`."""
    elements: int
    step: float
    """Time step [s]; 0 = the tool's own choice."""
    scene: str = "peers"
    """A file of evidence/drill_twin_evidence/benchmarks/scenes."""
    changes: Mapping[str, str] = field(default_factory=dict)
    """Overrides of the scene."""
    options: Mapping[str, Any] = field(default_factory=dict)
    """Options that only this tool knows."""
    limit: float = 120.0
    """Processor time after which the run is broken off [s]."""

    @property
    def label(self) -> str:
        """Tool, elements and step in a few words."""
        step = f", {self.step * 1e3:.4g} ms" if self.step else ""
        return f"{self.tool}, {self.elements} elements{step}"


@dataclass(frozen=True, eq=False)
class Motion:
    """Motion of a run, at T frames."""

    time: Array
    """Times of the frames that were reached [s], shape (T,)."""
    path: Array
    """Lateral place of mid-span [m], shape (T, 2)."""
    bottom: Array
    """Rise of the bottom [m], shape (T,)."""
    reach: Array
    """Largest distance of a node from the axis [m], shape (T,)."""
    cpu: float
    """Processor time of the stepping [s]; building and compiling are left out."""
    steps: int
    """Steps taken; 0 = not known."""
    failure: str = ""
    """Reason why it ended early."""

    @property
    def cost(self) -> float:
        """Processor time per simulated second [s/s]; infinite if it never got anywhere."""
        return self.cpu / float(self.time[-1]) if self.time.size else np.inf


class Recorder:
    """Takes the frames of a run and watches over it."""

    def __init__(self, limit: float) -> None:
        self.began = time.process_time()
        self.limit = limit
        self.failure = ""
        self.steps = 0
        self._rows: list[tuple[float, float, float, float, float]] = []

    def take(self, now: float, mid: Array, bottom: float, reach: float) -> bool:
        """Keep a frame; returns whether to go on."""
        row = (now, float(mid[0]), float(mid[1]), bottom, reach)
        if not np.isfinite(row).all():
            self.failure = f"not a number at {now:.3g} s"
            return False
        self._rows.append(row)
        return self.in_time(now)

    def in_time(self, now: float) -> bool:
        """True while the processor time lasts."""
        if time.process_time() - self.began > self.limit:
            self.failure = f"broken off at {now:.3g} s after {self.limit:.0f} s of processor time"
            return False
        return True

    def motion(self) -> Motion:
        """Motion kept so far."""
        cpu = time.process_time() - self.began
        rows = np.array(self._rows).reshape(-1, 5)
        return Motion(rows[:, 0], rows[:, 1:3], rows[:, 3], rows[:, 4], cpu, self.steps, self.failure)
