# SPDX-License-Identifier: Apache-2.0
"""Score over truths: errors of the numbers, coverage of the bands, errors of virtual sensors, warnings of whirl."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from scipy.special import chdtri

from drill_twin.core.table import Table
from drill_twin_evidence.estimation.cases import JUMP
from drill_twin_evidence.estimation.hidden_truth import TruthRow
from drill_twin_evidence.proportion import proportion_text
from drill_twin_studies.maps.proportions import proportion_interval

NEAR = 0.1
"""Relative error of a number that counts as found."""
AHEAD, EARLY = 2.0, 6.0
"""Least and largest time before the onset [s] of a warning that is ahead: the horizon of 4 s and two windows. An
earlier one is a false alarm.
"""


def score(runs: Sequence[TruthRow]) -> dict[str, Any]:
    """Score of the truths of one case, as plain types."""
    keys = list(runs[0]["held"])
    held = np.array([list(run["held"].values()) for run in runs])
    return {
        "truths": len(runs),
        "numbers": {
            key: {
                "median_error": float(np.median([abs(run["errors"][key]) for run in runs])),
                "found": _share([abs(run["errors"][key]) < NEAR for run in runs]),
                "held": _share(held[:, place].tolist()),
            }
            for place, key in enumerate(keys)
        },
        "numbers_held": float(held.mean()),
        "sensors": {name: found for name in runs[0]["coverage"] if (found := _sensor(runs, name))},
        "warnings": _warnings(runs),
        "alarms": {"hours": sum(run["seconds"] for run in runs) / 3600.0, "count": sum(len(r["alarms"]) for r in runs)},
        "withheld": float(np.mean([run["withheld"] for run in runs])),
        "jumps": _jumps(runs),
        "processor": float(np.mean([run["processor"] for run in runs])),
    }


def _sensor(runs: Sequence[TruthRow], name: str) -> dict[str, float]:
    held = np.array([run["coverage"][name] for run in runs])
    ratio = [run["error_ratio"][name] for run in runs]
    if not np.isfinite(held).any():
        return {}
    held = held[np.isfinite(held)]
    mean, width = float(held.mean()), 1.96 * float(held.std(ddof=1)) / math.sqrt(held.size) if held.size > 1 else 1.0
    interval = {"low": max(mean - width, 0.0), "high": min(mean + width, 1.0)}
    return {"held": mean, **interval, "error_over_open_loop": float(np.nanmedian(ratio))}


def _jumps(runs: Sequence[TruthRow]) -> dict[str, Any]:
    """Times until what jumped is found, and how far the rest is dragged; empty without jumps."""
    followed = {key: [run["followed"][key] for run in runs] for key in runs[0]["followed"]}
    dragged = {key: np.array([run["dragged"][key] for run in runs]) for key in runs[0]["dragged"]}
    if not dragged:
        return {}
    told = [[time - JUMP for time in run["alarms"] if time > JUMP] for run in runs]
    return {
        "followed_s": {
            key: {"median": float(np.median(times)), "longest": max(times)} for key, times in followed.items()
        },
        "dragged_at_the_end": {key: float(rows[:, 1].max()) for key, rows in dragged.items()},
        "dragged_most": {key: float(rows[:, 0].max()) for key, rows in dragged.items()},
        "told": sum(map(bool, told)),
        "held_or_told_at_the_end": sum(run["told"] or all(run["held"].values()) for run in runs),
        "told_within_s": max((times[0] for times in told if times), default=math.nan),
    }


def _warnings(runs: Sequence[TruthRow]) -> Mapping[str, float]:
    onsets = [run["onset"] for run in runs]
    leads = [[run["onset"] - time for time in run["warnings"] if time < run["onset"]] for run in runs]
    timely = [max(timely) for each in leads if (timely := [lead for lead in each if AHEAD <= lead <= EARLY])]
    calm = [onset if math.isfinite(onset) else run["seconds"] for onset, run in zip(onsets, runs, strict=True)]
    return {
        "onsets": sum(map(math.isfinite, onsets)),
        "warned_ahead": len(timely),
        "median_lead_s": float(np.median(timely)) if timely else float("nan"),
        "calm_hours": sum(calm) / 3600.0,
        "false_alarms": sum(any(lead > EARLY for lead in each) for each in leads)
        + sum(bool(run["warnings"]) for run in runs if not math.isfinite(run["onset"])),
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
        (sensor, f"{one['error_over_open_loop']:.2f}", f"{one['held']:.0%} ({one['low']:.0%} to {one['high']:.0%})")
        for sensor, one in found["sensors"].items()
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
    count, hours = found["alarms"]["count"], found["alarms"]["hours"]
    low, high = (24.0 / hours * end for end in rate_interval(count))
    sentence += f" Alarms of the misfit: {count} in {hours:.3g} h: {low:.2g} to {high:.2g} in 24 h (95 % interval)."
    sentence += f" Speed of the bit withheld in {found['withheld']:.1%} of the windows."
    return [*tables, "", sentence, *_jump_lines(found["jumps"]), ""]


def rate_interval(count: int) -> tuple[float, float]:
    """Limits of 95 % of the number that is expected where so many were counted (Garwood 1936)."""
    low = 0.5 * float(chdtri(2.0 * count, 0.975)) if count else 0.0
    return low, 0.5 * float(chdtri(2.0 * count + 2.0, 0.025))


def _jump_lines(found: Mapping[str, Any]) -> list[str]:
    if not found:
        return []
    rows = [
        (key, f"{time['median']:.0f} s, at most {time['longest']:.0f} s", "")
        for key, time in found["followed_s"].items()
    ]
    rows += [
        (key, "", f"{end:.1%}, on the way {found['dragged_most'][key]:.1%}")
        for key, end in found["dragged_at_the_end"].items()
    ]
    told = (
        f"Told in {found['told']}, within {found['told_within_s']:.0f} s. "
        f"All bands held, or an alarm at the end: {found['held_or_told_at_the_end']}."
    )
    return ["", Table(("jump", "followed after", "dragged at most"), rows).markdown(), "", told]


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
