# SPDX-License-Identifier: Apache-2.0
"""Score over truths: errors of the numbers, coverage of the bands, errors of virtual sensors, warnings of whirl."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from drill_twin.core.table import Table
from drill_twin.studies.maps.window import proportion_interval, proportion_text
from drill_twin_evidence.estimation.hidden_truth import Followed

NEAR = 0.1
"""Relative error of a number that counts as found."""
AHEAD, EARLY = 2.0, 6.0
"""Least and largest time before the onset [s] of a warning that is ahead: the horizon of 4 s and two windows. An
earlier one is a false alarm.
"""


def score(runs: Sequence[Followed]) -> dict[str, Any]:
    """Score of the runs of one case, as plain types."""
    keys = list(runs[0].hidden)
    held = np.array([list(run.held.values()) for run in runs])
    return {
        "truths": len(runs),
        "numbers": {
            key: {
                "median_error": float(np.median([abs(run.errors[key]) for run in runs])),
                "found": _share([abs(run.errors[key]) < NEAR for run in runs]),
                "held": _share(held[:, place].tolist()),
            }
            for place, key in enumerate(keys)
        },
        "numbers_held": float(held.mean()),
        "sensors": {name: found for name in runs[0].truth if (found := _sensor(runs, name))},
        "warnings": _warnings(runs),
        "processor": float(np.mean([run.processor for run in runs])),
    }


def _sensor(runs: Sequence[Followed], name: str) -> dict[str, float]:
    held = [run.coverage(name) for run in runs]
    ratio = [run.error_ratio(name) for run in runs]
    if not np.isfinite(held).any():
        return {}
    return {"held": float(np.nanmean(held)), "error_over_open_loop": float(np.nanmedian(ratio))}


def _warnings(runs: Sequence[Followed]) -> Mapping[str, float]:
    whirled = [run for run in runs if np.isfinite(run.onset)]
    leads = [[run.onset - time for time in run.warnings if time < run.onset] for run in whirled]
    timely = [max(timely) for each in leads if (timely := [lead for lead in each if AHEAD <= lead <= EARLY])]
    calm = [run.onset if np.isfinite(run.onset) else run.estimates[-1].time for run in runs]
    return {
        "onsets": len(whirled),
        "warned_ahead": len(timely),
        "median_lead_s": float(np.median(timely)) if timely else float("nan"),
        "calm_hours": sum(calm) / 3600.0,
        "false_alarms": sum(any(lead > EARLY for lead in each) for each in leads)
        + sum(bool(run.warnings) for run in runs if not np.isfinite(run.onset)),
    }


def _share(hits: Sequence[bool]) -> dict[str, float]:
    """Count, number and 95 % limits of a share."""
    low, high = proportion_interval(sum(hits), len(hits))
    return {"count": sum(hits), "of": len(hits), "low": low, "high": high}


def lines(name: str, found: Mapping[str, Any]) -> list[str]:
    """The score as lines of Markdown."""
    heads = (f"{name}: {found['truths']} truths", "median error", "within 10 %", "90 % band holds")
    numbers = (
        (key, f"{one['median_error']:.1%}", _told(one["found"]), _told(one["held"]))
        for key, one in found["numbers"].items()
    )
    sensors = (
        (sensor, f"{one['error_over_open_loop']:.2f}", f"{one['held']:.0%}") for sensor, one in found["sensors"].items()
    )
    of_sensors = Table(("virtual sensor", "error over open loop's", "90 % band holds"), sensors)
    tables = [Table(heads, numbers).markdown(), "", of_sensors.markdown()]
    told = found["warnings"]
    sentence = (
        f"Bands of all numbers hold {found['numbers_held']:.0%}. Whirl: {told['onsets']} onsets, "
        f"warned {AHEAD:g} to {EARLY:g} s ahead: {proportion_text(told['warned_ahead'], told['onsets'])}, median "
        f"{told['median_lead_s']:.1f} s; runs with a false alarm, earlier ones included: {told['false_alarms']} in "
        f"{told['calm_hours']:.2f} h before or without whirl. "
        f"Processor: {found['processor']:.2f} of a core."
    )
    return [*tables, "", sentence, ""]


def _told(share: Mapping[str, float]) -> str:
    return proportion_text(int(share["count"]), int(share["of"]))


def cost_lines(name: str, by_members: Mapping[int, Mapping[str, Any]]) -> list[str]:
    """Error against members and processor time as lines of Markdown."""
    rows = []
    for members, found in by_members.items():
        error = np.median([of_key["median_error"] for of_key in found["numbers"].values()])
        ratio = np.median([of_sensor["error_over_open_loop"] for of_sensor in found["sensors"].values()])
        held, processor = found["numbers_held"], found["processor"]
        rows.append((members, f"{error:.2%}", f"{held:.0%}", f"{ratio:.2f}", f"{processor:.2f}"))
    heads = (f"{name}: members", "median error of the numbers", "bands hold", "error over open loop's", "of a core")
    return [Table(heads, rows).markdown(), ""]
