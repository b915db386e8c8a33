# SPDX-License-Identifier: Apache-2.0
"""A measured number beside the computed one, and what the comparison with a record holds."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
from scipy import signal

from drill_twin.core.arrays import Array
from drill_twin.core.errors import ArgumentError

VARIABLE = "DRILL_TWIN_DATA"
"""Environment variable that names the folder of the records."""


@dataclass(frozen=True)
class Comparison:
    """A number of a record and the twin's.

    Attributes:
        what: Quantity, with its unit in brackets.
        kind: "fit" where the numbers of the scene were fitted to this part of the record, else "prediction".
        measured: From the record; None for an error, which is itself a comparison.
        computed: From the twin.
        aim: Largest difference aimed at, relative to the measured number; for an error the
            largest one; infinite without an aim.
    """

    what: str
    kind: Literal["fit", "prediction"]
    measured: float | None
    computed: float
    aim: float

    @property
    def difference(self) -> float:
        """Relative difference from the measured number; of an error the error itself."""
        return self.computed if self.measured is None else self.computed / self.measured - 1.0

    @property
    def met(self) -> bool:
        """True where the aim is met."""
        return math.isfinite(self.difference) and abs(self.difference) <= self.aim


class Trace(NamedTuple):
    """A channel over time, measured and computed."""

    label: str
    time: Array
    measured: Array
    computed: Array


@dataclass(frozen=True)
class Validation:
    """Comparison with one record.

    Attributes:
        record: Name of the record.
        scene: Name of the scene.
        about: What was fitted to what, in sentences.
        comparisons: The numbers.
        traces: Channels of the figure.
        fitted_until: End of the part of the record that was fitted to [s].
    """

    record: str
    scene: str
    about: str
    comparisons: Sequence[Comparison]
    traces: Sequence[Trace]
    fitted_until: float

    def to_dict(self) -> dict[str, Any]:
        """Plain types for JSON."""
        rows = [asdict(row) | {"difference": row.difference, "met": row.met} for row in self.comparisons]
        return {"record": self.record, "scene": self.scene, "about": self.about, "comparisons": rows}


def data_folder(given: Path | None, environment: Mapping[str, str] = os.environ) -> Path:
    """Folder of the records: the given one, else that of `DRILL_TWIN_DATA`.

    Raises:
        ArgumentError: Neither names a folder.
    """
    folder = given or Path(environment.get(VARIABLE, "") or ".")
    if (given is None and not environment.get(VARIABLE)) or not folder.is_dir():
        found = given or environment.get(VARIABLE) or "none"
        raise ArgumentError(
            f"records: expected a folder with ufrj_rig/ or well_b/, found {found}; name it with --data or {VARIABLE}"
        )
    return folder


def rms(values: Array) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(values**2)))


def cycle_length(values: Array, period: float, shortest: float, longest: float) -> float:
    """Lag of the largest autocorrelation between a shortest and a longest one [s], refined by a parabola."""
    centred = values - values.mean()
    correlation = signal.correlate(centred, centred)[centred.size - 1 :] / np.arange(centred.size, 0, -1)
    first, last = round(shortest / period), round(longest / period)
    peak = first + int(np.argmax(correlation[first : last + 1]))
    near = np.arange(peak - max(1, peak // 10), peak + max(1, peak // 10) + 1)
    curve, slope, _ = np.polyfit(near - peak, correlation[near], 2)
    return float(period * (peak - 0.5 * slope / curve))
