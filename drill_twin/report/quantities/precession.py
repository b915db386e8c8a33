# SPDX-License-Identifier: Apache-2.0
"""Precession of the leading mark over the whirl of a recording, with the meaning of each number."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from drill_twin.report.recording import Recording
from drill_twin.whirl.spectrum import WINDOW, centre_line, precession_record


def precession(recording: Recording) -> dict[str, Any]:
    """Keys of the summary on the precession at `frequency_mark` from the onset until the whirl ends.

    * `whirl_frequency_interval_hz`: smallest and largest mean over windows of `window_rev` revolutions [Hz].
    * `spectrum_lines`: highest lines of the spectrum: `frequency_hz`, `radius_m`.
    * `ratios`: precession over rotation as `mode` (the most frequent), as `line` (the highest of the spectrum) and as
      `mean` (weighted by the radius); None where unknown.
    """
    found = recording.summary
    result: dict[str, Any] = {
        "window_rev": WINDOW,
        "whirl_frequency_interval_hz": None,
        "spectrum_lines": [],
        "ratios": {"mode": found.mode_ratio, "line": None, "mean": None},
    }
    rotation = found.rotation_rev_s
    if found.onset_s is None or found.frequency_mark is None or not rotation:
        return result
    mark = [place.name for place in recording.places].index(found.frequency_mark)
    end = math.inf if found.whirl_end_s is None else found.whirl_end_s
    whirl, marks, place = recording.whirl, recording.marks, recording.places[mark]
    common, of_whirl, of_marks = np.intersect1d(whirl.time, marks.time, return_indices=True)
    chosen = (common >= found.onset_s) & (common <= end)
    time, at, seen = common[chosen], of_whirl[chosen], of_marks[chosen]
    column = marks.names.index(place.name)
    x, y = np.moveaxis(marks.position[seen, column, :2], -1, 0)
    spin = marks.spin[seen, column] if place.on == "wall" else None
    record = precession_record(
        time, whirl.precession[at, mark], whirl.ratio[at, mark], whirl.orbit_radius[at, mark],
        centre_line(x, y, spin, place.wall_offset), rotation,
    )  # fmt: skip
    result["whirl_frequency_interval_hz"] = record.interval_hz
    result["spectrum_lines"] = [{"frequency_hz": line.frequency, "radius_m": line.radius} for line in record.lines]
    result["ratios"]["mean"] = record.mean_ratio
    if record.lines:
        result["ratios"]["line"] = record.lines[0].frequency / abs(rotation)
    return result
