# SPDX-License-Identifier: Apache-2.0
"""Outputs of a member, gathered chunk by chunk; but for `marks` and `channels` memory does not grow with the run."""

from __future__ import annotations

from collections.abc import Mapping

from drill_twin.runs.ensemble.collector import Collector, Request, Variable
from drill_twin.runs.ensemble.run_outputs import Contact, Energy, Extremes, Fatigue, LastHalf, Settling
from drill_twin.runs.ensemble.time_outputs import Channels, Findings, Instants, Marks, Spectra

__all__ = ["OUTPUTS", "Collector", "Request", "Variable"]

OUTPUTS: Mapping[str, type[Collector]] = {
    "findings": Findings,
    "extremes": Extremes,
    "contact": Contact,
    "last_half": LastHalf,
    "settling": Settling,
    "marks": Marks,
    "channels": Channels,
    "instants": Instants,
    "spectra": Spectra,
    "energy": Energy,
    "fatigue": Fatigue,
}
"""Outputs by name."""
