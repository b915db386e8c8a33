# SPDX-License-Identifier: Apache-2.0
"""Error model of a scene: error and time over resolution, and its files."""

from __future__ import annotations

import hashlib
import json
import logging
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
from drill_twin.base.json_reader import read_json
from drill_twin.scene import Scene
from drill_twin.scene.paths import config_dir
from drill_twin.solver.kernel_cache import cache_folder
from drill_twin.solver.machine_code import read_own, write_own

_LOG = logging.getLogger(__name__)

MARGIN = 2.0
"""Safety factor on the measured error."""
REFERENCE_SHARE = 1.0 / 3.0
"""Error of the converged run over the smallest error measured against it: second order, half the step."""
FOLDER = "accuracy"


@dataclass(frozen=True)
class Point:
    """Errors and cost of a resolution."""

    elements: int
    step: float
    """[s]"""
    tolerance: float
    """Tolerance of Newton's method."""
    path: float
    """Error of the path before the onset [-]."""
    onset: float
    """Error of the onset time [-]; 0 where there is no onset."""
    before: float
    """Processor time per simulated second before the onset [s/s]."""
    after: float
    """Processor time per simulated second after it; as `before` where there is no onset [s/s]."""

    @property
    def error(self) -> float:
        """The error that `accuracy` controls: the larger of the two [-]."""
        return max(self.path, self.onset)


@dataclass(frozen=True)
class ErrorModel:
    """Errors and costs of one scene at several resolutions."""

    key: str
    """Hash of the parts of the scene that its motion depends on (`content_key`)."""
    machine: str
    """Class of the machine on which the times were measured."""
    onset_s: float | None
    """Onset of the converged run [s]."""
    points: tuple[Point, ...]

    def cheapest(self, accuracy: float) -> Point | None:
        """The cheapest resolution whose error is below the accuracy with a margin; None if there is none.

        A resolution counts only if every finer one is accurate enough too: otherwise its small error is a coincidence.
        """
        fit = [point for point in self.points if MARGIN * max(map(self.expected, self._finer(point))) <= accuracy]
        return min(fit, key=lambda point: self.seconds(point, 2.0 * (self.onset_s or 1.0)), default=None)

    def expected(self, point: Point) -> float:
        """Expected error [-]: that against the converged run, plus the error of the converged run itself."""
        return point.error + REFERENCE_SHARE * self.best

    def _finer(self, point: Point) -> list[Point]:
        """All resolutions that are at least as fine as this one, which is among them."""
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
        """Processor time of a run [s] of a simulated duration [s]."""
        early = duration if self.onset_s is None else min(self.onset_s, duration)
        return point.before * early + point.after * (duration - early)

    def save(self, path: Path) -> None:
        """Write the model as JSON, then rename the file, so that no reader finds half of it."""
        path.parent.mkdir(parents=True, exist_ok=True)
        write_own(path, (json.dumps(asdict(self), indent=1) + "\n").encode())

    @staticmethod
    def load(path: Path) -> ErrorModel:
        """Read a model that was saved."""
        return ErrorModel.parse(path.read_bytes())

    @staticmethod
    def parse(content: bytes) -> ErrorModel:
        """Model of a file's content.

        Raises:
            ValueError, TypeError, KeyError: It is damaged.
        """
        data: dict[str, Any] = read_json(content)
        return ErrorModel(**{**data, "points": tuple(Point(**point) for point in data["points"])})


def content_key(scene: Scene) -> str:
    """Hash of all that the motion of a scene depends on, except its resolution and its texts."""
    data = scene.model_dump(mode="json", exclude_defaults=True)  # a new field leaves the key of older scenes
    for key in ("name", "description", "provenance"):
        data.pop(key, None)
    for key in ("elements", "step", "tolerance", "accuracy", "audit"):
        data.get("numerics", {}).pop(key, None)
    return hashlib.sha256(json.dumps(data, sort_keys=True).encode()).hexdigest()[:16]


def machine_class() -> str:
    """Processor and architecture, which decide the speed of a run."""
    return f"{llvmlite.binding.get_host_cpu_name()} {platform.machine()}"


def from_motions(scene: Scene, reference: Motion, motions: Sequence[Motion], later: float = 1.0) -> ErrorModel:
    """Error model from runs of a scene and its converged run.

    Args:
        scene: The scene.
        reference: The converged run.
        motions: Runs of the same duration.
        later: Cost after the onset over that part of it which these runs cover.
    """
    onset = None if np.isnan(reference.onset) else float(reference.onset)
    return ErrorModel(
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


def load_model(scene: Scene) -> tuple[ErrorModel, str] | None:
    """Error model of a scene and its origin, `cached` on this machine or `shipped`; None if there is none."""
    key = content_key(scene)
    here = _cache_path(key)
    content = read_own(here)
    if content is not None:
        try:
            return ErrorModel.parse(content), "cached"
        except (ValueError, TypeError, KeyError, RecursionError):
            _LOG.warning("%s: damaged, measured again", here)
    for path in sorted((config_dir() / FOLDER).glob("*.json")):
        shipped = ErrorModel.load(path)
        if shipped.key == key:
            return shipped, "shipped"
    return None


def save_model(model: ErrorModel) -> None:
    """Save a model in the user's cache folder; version and machine are part of its file name."""
    model.save(_cache_path(model.key))


def _cache_path(key: str) -> Path:
    machine = hashlib.sha256(machine_class().encode()).hexdigest()[:8]
    return cache_folder() / FOLDER / f"{key}-{machine}-{__version__}.json"
