# SPDX-License-Identifier: Apache-2.0
"""Findings of the whirl analysis."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from drill_twin.core.missing import number_or_nan
from drill_twin.dynamics.twin.frame_record import FrameSeries, RigSeries
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.io.messages.encode import wall_push
from drill_twin.io.messages.stamps import stamp_ns
from drill_twin.io.scene_geometry import mark_infos
from drill_twin.runs.ensemble.outputs.collector import Collector, Request, Variable
from drill_twin.whirl import Analyzer, BitOnlyAnalyzer, Summary


class Findings(Collector):
    """Whirl analysis, as the analyzer node makes it of the messages."""

    def __init__(self, twin: Twin, request: Request) -> None:
        super().__init__(twin, request)
        infos = mark_infos(twin.scene)
        self._analyzer = Analyzer(infos) if infos else None
        self._bit = BitOnlyAnalyzer()

    def add(self, rows: FrameSeries, rig: RigSeries) -> None:
        """Add a sample for each frame."""
        stamps = [stamp_ns(time) for time in rows.time.tolist()]
        if self._analyzer is None:
            for sample in zip(stamps, rig.top_drive_speed.tolist(), rig.bit_speed.tolist(), strict=True):
                self._bit.push(*sample)
            return
        push = wall_push(rows.centre, rows.wall_force)  # as `/marks/state` has it
        force = np.hypot(push[..., 0], push[..., 1])
        self._analyzer.push_block(np.array(stamps), rows.position, rows.spin, rig.top_drive_speed, force, rig.bit_speed)

    def close(self) -> Mapping[str, Variable]:
        """Onset, motion and precession; `summary` has the rest."""
        found: Summary = self._bit.summary() if self._analyzer is None else self._analyzer.summary()
        return {
            "onset_s": Variable(number_or_nan(found.onset_s), (), "s"),
            "motion": Variable(found.motion[-1].state.value if found.motion else "unknown", (), ""),
            "whirl_frequency_hz": Variable(number_or_nan(found.whirl_frequency_hz), (), "rev/s"),
            "precession_ratio": Variable(number_or_nan(found.precession_ratio), (), "1"),
            "summary": Variable(found, (), ""),
        }
