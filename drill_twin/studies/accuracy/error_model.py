# SPDX-License-Identifier: Apache-2.0
"""Error model of a scene: errors and Newton iterations over resolution, and its files.

It holds no times. An iteration of a resolution takes the same time all along a run, so the iterations of the curve and
the time of one on this machine, measured before the run, give the time of the run.
"""

import hashlib
import json
import logging
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated, Self

import numpy as np
from pydantic import Field, TypeAdapter

from drill_twin.core import __version__
from drill_twin.core.arrays import number_or_none
from drill_twin.core.files.json_files import LARGEST_TEXT
from drill_twin.core.files.kept_files import cache_folder, cached_file, read_own
from drill_twin.core.files.output import PRIVATE, write_whole
from drill_twin.scene import Scene
from drill_twin.scene.paths import config_dir
from drill_twin.studies.accuracy.errors import errors_before
from drill_twin.studies.accuracy.motion_run import Motion

_LOG = logging.getLogger(__name__)

MARGIN = 2.0
"""Safety factor on the measured error."""
REFERENCE_SHARE = 1.0 / 3.0
"""Error of the converged run over the smallest error measured against it: second order, half the step."""
OVERHEAD = 3.0
"""Time of an iteration that does not depend on the elements, over the time of an element."""
COARSER = 1.5
"""Least ratio of elements, and of steps, between the converged run and a resolution that is compared with it."""
FOLDER = "accuracy"

_Elements = Annotated[int, Field(gt=0, le=100_000)]
_Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
_Number = Annotated[float, Field(ge=0.0, allow_inf_nan=False)]
_Error = Annotated[float, Field(ge=0.0)]  # infinite for a run without an onset that there is


@dataclass(frozen=True)
class MeasuredPoint:
    """Errors and effort of a resolution."""

    elements: _Elements
    step: _Positive
    """[s]"""
    tolerance: _Positive
    """Tolerance of Newton's method."""
    path: _Error
    """Error of the path before the onset [-]."""
    onset: _Error
    """Error of the onset time [-]; 0 where there is no onset."""
    before: _Number
    """Newton iterations per simulated second before the onset [1/s]."""
    after: _Number
    """Newton iterations per simulated second after it; as `before` where there is no onset [1/s]."""

    @property
    def error(self) -> float:
        """The error that `accuracy` controls: the larger of the two [-]."""
        return max(self.path, self.onset)


@dataclass(frozen=True)
class ErrorModel:
    """Errors and effort of one scene at several resolutions."""

    key: str
    """Hash of the parts of the scene that its motion depends on (`content_key`)."""
    onset_s: _Number | None
    """Onset of the converged run [s]."""
    covered_s: _Number
    """Simulated time that the runs cover [s]."""
    elements: _Elements
    """Elements of the converged run."""
    step: _Positive
    """Time step of the converged run [s]."""
    ended: str
    """End of the measurement: `reached`, `budget`, or `finest`."""
    points: tuple[MeasuredPoint, ...]

    def covers(self, duration: float) -> bool:
        """True if it tells the errors of a run of a simulated duration [s]: all that is before the onset."""
        return self.onset_s is not None or duration <= self.covered_s * (1.0 + 1e-9)

    def cheapest(self, accuracy: float) -> MeasuredPoint | None:
        """The cheapest resolution whose error is below the accuracy with a margin; None if there is none.

        A resolution counts only if every finer one is accurate enough too: otherwise its small error is a coincidence.
        """
        fit = [point for point in self.judged if MARGIN * max(map(self.expected, self._finer(point))) <= accuracy]
        return min(fit, key=lambda point: self.effort(point, 2.0 * (self.onset_s or 1.0)), default=None)

    def expected(self, point: MeasuredPoint) -> float:
        """Expected error [-]: that against the converged run, plus the error of the converged run itself."""
        return point.error + REFERENCE_SHARE * self.best

    def _finer(self, point: MeasuredPoint) -> list[MeasuredPoint]:
        """All resolutions that are at least as fine as this one, which is among them."""
        return [
            other
            for other in self.points
            if other.elements >= point.elements and other.step <= point.step and other.tolerance <= point.tolerance
        ]

    @property
    def best(self) -> float:
        """Smallest error that was measured [-]."""
        return min((point.error for point in self.judged), default=1.0)

    @property
    def judged(self) -> list[MeasuredPoint]:
        """Resolutions so coarse that comparison with the converged run shows their error of mesh and step."""
        return [
            point
            for point in self.points
            if COARSER * point.elements <= self.elements and COARSER * self.step <= point.step
        ]

    def iterations(self, point: MeasuredPoint, duration: float) -> float:
        """Newton iterations of a run of a simulated duration [s]."""
        early = duration if self.onset_s is None else min(self.onset_s, duration)
        return point.before * early + point.after * (duration - early)

    def effort(self, point: MeasuredPoint, duration: float) -> float:
        """Time of a run of a simulated duration [s], in times of one element in one iteration."""
        return self.iterations(point, duration) * (point.elements + OVERHEAD)

    def save(self, path: Path) -> None:
        """Write the model as JSON, as a whole or not at all."""
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, json.dumps(asdict(self), indent=1) + "\n", PRIVATE)

    @classmethod
    def parse(cls, content: bytes) -> Self:
        """Model of a file's content.

        Raises:
            ValueError: It is damaged.
        """
        if len(content) > LARGEST_TEXT:
            raise ValueError(f"{len(content)} bytes where at most {LARGEST_TEXT} can be meant")
        return TypeAdapter(cls).validate_json(content, strict=True)


def content_key(scene: Scene) -> str:
    """Hash of all that the motion of a scene depends on, except resolution, duration and texts."""
    data = scene.model_dump(mode="json", exclude_defaults=True)  # a new field leaves the key of older scenes
    for key in ("name", "description", "provenance", "units", "sensors"):
        data.pop(key, None)
    data.get("rig", {}).pop("duration", None)
    for key in ("elements", "step", "tolerance", "accuracy", "audit"):
        data.get("numerics", {}).pop(key, None)
    if not data.get("numerics"):
        data.pop("numerics", None)  # as in a scene that names none
    if scene.rig.table is not None and (record := Path(scene.rig.table.file)).is_file():
        with record.open("rb") as stream:
            data["record"] = hashlib.file_digest(stream, "sha256").hexdigest()
    return hashlib.sha256(json.dumps(data, sort_keys=True).encode()).hexdigest()[:16]


def from_motions(
    scene: Scene, reference: Motion, motions: Sequence[Motion], *, later: float = 1.0, ended: str = "reached"
) -> ErrorModel:
    """Error model from runs of a scene and its converged run.

    Args:
        scene: The scene.
        reference: The converged run.
        motions: Runs at other resolutions.
        later: Newton iterations per second after the onset, over their number in the part which these runs cover.
        ended: End of the measurement.
    """
    onset, covered = number_or_none(reference.onset), float(reference.time[-1])
    points = []
    for motion in motions:
        errors, (before, after) = errors_before(motion, reference), rates(motion, onset)
        points.append(MeasuredPoint(motion.elements, motion.step, motion.tolerance, *errors, before, later * after))
    return ErrorModel(content_key(scene), onset, covered, reference.elements, reference.step, ended, tuple(points))


def rates(motion: Motion, onset: float | None, end: float = np.inf) -> tuple[float, float]:
    """Newton iterations per simulated second before an onset [s] and after it, up to an end [s]."""
    early = motion.time <= (np.inf if onset is None else onset)
    late = ~early & (motion.time <= end)
    period = float(motion.time[0])
    before = float(motion.iterations[early].mean()) / period
    return before, float(motion.iterations[late].mean()) / period if late.any() else before


def load_model(scene: Scene) -> tuple[ErrorModel, str] | None:
    """Error model of a scene and its origin, `cached` on this machine or `shipped`; None if there is none."""
    key = content_key(scene)
    here = cached_file(_cache_name(key))
    if (content := read_own(here)) is not None:
        try:
            return ErrorModel.parse(content), "cached"
        except ValueError:
            _LOG.warning("%s: damaged, measured again", here)
    for path in sorted((config_dir() / FOLDER).glob("*.json")):
        try:
            shipped = ErrorModel.parse(path.read_bytes())
        except (OSError, ValueError):
            _LOG.warning("%s: no accuracy of a scene, left out", path)
            continue
        if shipped.key == key:
            return shipped, "shipped"
    return None


def save_model(model: ErrorModel) -> None:
    """Save a model in the user's cache folder; the version is part of its file name."""
    path = cache_folder() / _cache_name(model.key)
    try:
        model.save(path)
    except OSError as error:
        _LOG.warning("%s: not kept: %s", path, error.strerror or error)


def _cache_name(key: str) -> str:
    return f"{FOLDER}/{key}-{__version__}.json"
