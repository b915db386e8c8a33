# SPDX-License-Identifier: Apache-2.0
"""Score over truths: errors of the numbers, coverage of the bands, errors of virtual sensors, warnings of whirl."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from drill_twin.studies.estimation.hidden_truth import Followed

NEAR = 0.1
"""Relative error of a number that counts as found."""
AHEAD = 2.0
"""Time before the onset [s] that a warning needs."""


def score(runs: Sequence[Followed]) -> dict[str, Any]:
    """Score of the runs of one case, as plain types."""
    keys = list(runs[0].hidden)
    held = np.array([list(run.held.values()) for run in runs])
    return {
        "truths": len(runs),
        "numbers": {
            key: {
                "median_error": float(np.median([abs(run.errors[key]) for run in runs])),
                "found": float(np.mean([abs(run.errors[key]) < NEAR for run in runs])),
                "held": float(held[:, place].mean()),
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
    calm = [run for run in runs if not np.isfinite(run.onset)]
    return {
        "onsets": len(whirled),
        "warned_ahead": sum(run.onset - run.warned >= AHEAD for run in whirled),
        "median_lead_s": float(np.median([run.onset - run.warned for run in whirled])) if whirled else float("nan"),
        "calm_hours": sum(run.estimates[-1].time for run in calm) / 3600.0,
        "false_alarms": sum(bool(np.isfinite(run.warned)) for run in calm),
    }


def lines(name: str, found: Mapping[str, Any]) -> list[str]:
    """The score as lines of Markdown."""
    table = [f"| {name}: {found['truths']} truths | median error | within 10 % | 90 % band holds |",
             "| --- | --- | --- | --- |"]  # fmt: skip
    for key, of_key in found["numbers"].items():
        table.append(f"| {key} | {of_key['median_error']:.1%} | {of_key['found']:.0%} | {of_key['held']:.0%} |")
    table += ["", "| virtual sensor | error over open loop's | 90 % band holds |", "| --- | --- | --- |"]
    for sensor, of_sensor in found["sensors"].items():
        table.append(f"| {sensor} | {of_sensor['error_over_open_loop']:.2f} | {of_sensor['held']:.0%} |")
    told = found["warnings"]
    sentence = (
        f"Bands of all numbers hold {found['numbers_held']:.0%}. Whirl: {told['onsets']} onsets, "
        f"{told['warned_ahead']} warned {AHEAD:g} s ahead or more (median {told['median_lead_s']:.1f} s); "
        f"{told['false_alarms']} false alarms in {told['calm_hours']:.2f} h without whirl. "
        f"Processor: {found['processor']:.2f} of a core."
    )
    return [*table, "", sentence, ""]


def cost_lines(name: str, by_members: Mapping[int, Mapping[str, Any]]) -> list[str]:
    """Error against members and processor time as lines of Markdown."""
    table = [f"| {name}: members | median error of the numbers | bands hold | error over open loop's | of a core |",
             "| --- | --- | --- | --- | --- |"]  # fmt: skip
    for members, found in by_members.items():
        error = np.median([of_key["median_error"] for of_key in found["numbers"].values()])
        ratio = np.median([of_sensor["error_over_open_loop"] for of_sensor in found["sensors"].values()])
        held, processor = found["numbers_held"], found["processor"]
        table.append(f"| {members} | {error:.2%} | {held:.0%} | {ratio:.2f} | {processor:.2f} |")
    return [*table, ""]
