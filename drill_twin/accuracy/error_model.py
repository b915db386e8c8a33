# SPDX-License-Identifier: Apache-2.0
"""What a cost curve lets one promise: error and time over resolution, for one scene; where such curves are kept."""

from __future__ import annotations

import hashlib
import json
import platform
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import llvmlite.binding
import numpy as np

from drill_twin import __version__
from drill_twin.accuracy.errors import compare
from drill_twin.accuracy.motion_run import Motion
from drill_twin.scene import Scene
from drill_twin.scene.paths import config_dir
from drill_twin.solver.kernel_cache import cache_folder

MARGIN = 2.0
"""The error that was measured, times this, is below what is promised."""
REST = 1.0 / 3.0
"""Error of the converged run over the smallest that was measured against it: second order, half the step."""
FOLDER = "accuracy"


@dataclass(frozen=True)
class Point:
    """A resolution and what it showed."""

    elements: int
    step: float
    """[s]"""
    tolerance: float
    """Of Newton's method."""
    path: float
    """Error of the path before the onset [-]."""
    onset: float
    """Error of the onset time [-]; 0 where there is no onset."""
    before: float
    """Processor time per simulated second before the onset [s/s]."""
    after: float
    """The same after it; as before where there is no onset [s/s]."""

    @property
    def error(self) -> float:
        """What `accuracy` promises: the larger of the two."""
        return max(self.path, self.onset)


@dataclass(frozen=True)
class Promise:
    """The cost curve of one scene, as far as a promise needs it."""

    key: str
    """Hash of all in the scene that its motion depends on (`content_key`)."""
    machine: str
    """Class of the machine that the times are of."""
    onset_s: float | None
    """Onset of the converged run [s]."""
    points: tuple[Point, ...]

    def cheapest(self, accuracy: float) -> Point | None:
        """The cheapest resolution whose error is below the accuracy with a margin; None if there is none.

        A finer one that is worse shows that it was luck: then neither counts.
        """
        fit = [point for point in self.points if MARGIN * max(map(self.expected, self._finer(point))) <= accuracy]
        return min(fit, key=lambda point: self.seconds(point, 2.0 * (self.onset_s or 1.0)), default=None)

    def expected(self, point: Point) -> float:
        """Error to expect [-]: against the converged run, and what that one may be off itself."""
        return point.error + REST * self.best

    def _finer(self, point: Point) -> list[Point]:
        """This and all that are at least as fine."""
        return [
            other
            for other in self.points
            if other.elements >= point.elements and other.step <= point.step and other.tolerance <= point.tolerance
        ]

    @property
    def best(self) -> float:
        """Smallest error that was measured [-]."""
        return min(point.error for point in self.points)

    def seconds(self, point: Point, duration: float) -> float:
        """Processor time of a run of so many simulated seconds [s]."""
        early = duration if self.onset_s is None else min(self.onset_s, duration)
        return point.before * early + point.after * (duration - early)

    def save(self, path: Path) -> None:
        """Write it as JSON; a half-written file is never seen."""
        path.parent.mkdir(parents=True, exist_ok=True)
        part = path.with_suffix(".part")
        part.write_text(json.dumps(asdict(self), indent=1) + "\n", "utf-8")
        part.replace(path)

    @staticmethod
    def load(path: Path) -> Promise:
        """Read one that was saved."""
        data: dict[str, Any] = json.loads(path.read_text("utf-8"))
        return Promise(**{**data, "points": tuple(Point(**point) for point in data["points"])})


def content_key(scene: Scene) -> str:
    """Hash of all that the scene's motion depends on but its resolution; texts do not count."""
    data = scene.model_dump(mode="json", exclude_defaults=True)  # a field that is new changes no older scene
    for key in ("name", "description", "provenance"):
        data.pop(key, None)
    for key in ("elements", "step", "tolerance", "accuracy", "audit"):
        data.get("numerics", {}).pop(key, None)
    return hashlib.sha256(json.dumps(data, sort_keys=True).encode()).hexdigest()[:16]


def machine_class() -> str:
    """What decides how fast the machine is, in words: processor and architecture."""
    return f"{llvmlite.binding.get_host_cpu_name()} {platform.machine()}"


def from_motions(scene: Scene, reference: Motion, motions: Sequence[Motion], later: float = 1.0) -> Promise:
    """Compare runs of a scene with its converged run.

    Args:
        scene: The scene.
        reference: The converged run.
        motions: The runs, as long as it.
        later: Cost after the onset over that which these runs show of it.
    """
    onset = None if np.isnan(reference.onset) else float(reference.onset)
    return Promise(
        content_key(scene), machine_class(), onset, tuple(_point(motion, reference, onset, later) for motion in motions)
    )


def _point(motion: Motion, reference: Motion, onset: float | None, later: float) -> Point:
    errors = compare(motion, reference)
    early = motion.time <= (np.inf if onset is None else onset)
    period = float(motion.time[0])
    before = float(motion.spent[early].mean()) / period
    after = before if early.all() else later * float(motion.spent[~early].mean()) / period
    return Point(
        elements=motion.elements, step=motion.step, tolerance=motion.tolerance, path=errors.path or 0.0,
        onset=errors.onset or 0.0, before=before, after=after,
    )  # fmt: skip


def kept(scene: Scene) -> tuple[Promise, str] | None:
    """The curve of a scene and where it comes from: `cached` on this machine, or `shipped`; None if there is none."""
    key = content_key(scene)
    here = _place(key)
    if here.is_file():
        return Promise.load(here), "cached"
    for path in sorted((config_dir() / FOLDER).glob("*.json")):
        shipped = Promise.load(path)
        if shipped.key == key:
            return shipped, "shipped"
    return None


def keep(promise: Promise) -> None:
    """Keep a curve in the user's cache folder; the version and the machine are part of its name."""
    promise.save(_place(promise.key))


def _place(key: str) -> Path:
    machine = hashlib.sha256(machine_class().encode()).hexdigest()[:8]
    return cache_folder() / FOLDER / f"{key}-{machine}-{__version__}.json"
