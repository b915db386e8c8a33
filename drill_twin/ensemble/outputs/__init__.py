# SPDX-License-Identifier: Apache-2.0
"""Outputs of a member, gathered chunk by chunk; but for `marks` and `channels` memory does not grow with the run."""

from __future__ import annotations

from collections.abc import Mapping

from drill_twin.ensemble.outputs.collector import Collector, Request, Variable
from drill_twin.ensemble.outputs.findings import Findings
from drill_twin.ensemble.outputs.series import Channels, Marks
from drill_twin.ensemble.outputs.severity import Contact, Extremes, LastHalf
from drill_twin.ensemble.outputs.spectra import Spectra
from drill_twin.ensemble.outputs.totals import Energy, Fatigue
from drill_twin.twin.frame import Frames
from drill_twin.twin.frame_kernel import Rows
from drill_twin.twin.observer import rig_rows
from drill_twin.twin.twin import Twin

__all__ = ["OUTPUTS", "Collector", "Request", "Variable", "collect", "first_rows"]

OUTPUTS: Mapping[str, type[Collector]] = {
    "findings": Findings,
    "extremes": Extremes,
    "contact": Contact,
    "last_half": LastHalf,
    "marks": Marks,
    "channels": Channels,
    "spectra": Spectra,
    "energy": Energy,
    "fatigue": Fatigue,
}
"""Outputs by name."""


def collect(collectors: list[Collector], twin: Twin, rows: Rows, period: float, frames: Frames | None = None) -> None:
    """Give frames of a length [s] to all collectors, with the state of all nodes to those that take it."""
    if rows.time.size:
        rig = rig_rows(twin.dynamics, rows, period)
        for collector in collectors:
            collector.add(rows, rig)
            if collector.whole and frames is not None:
                collector.add_frames(frames)


def first_rows(rows: Rows, count: int) -> Rows:
    """The first frames of a record; views."""
    return Rows(*(column[:count] for column in rows))
