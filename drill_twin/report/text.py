# SPDX-License-Identifier: Apache-2.0
"""Summary as text: rows of the tables of the command line and the page, and the limits of validity."""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from drill_twin.report.load_text import (
    Row,
    Summary,
    bit_rows,
    fatigue_rows,
    load_rows,
    number_text,
    severity_rows,
    sub_rows,
    surface_rows,
    units_of,
)
from drill_twin.whirl import MotionState, criteria

_OF_THE_STRING = {MotionState.SPIRAL.value, MotionState.SECOND_BENDING.value}
"""States of the string's shape, which no single mark can have."""
FIELD_NAMES = {
    **dict.fromkeys((MotionState.ROLLING.value, MotionState.CREEPING.value), "backward whirl"),
    MotionState.IRREGULAR.value: "chaotic whirl",
}
"""Field names of states that have another name here (vocabulary of D-WIS)."""
ON_THE_WALL = 1.005
"""Radius over the clearance from which a row tells how deep in the wall a mark was; not measured."""
NOT_VALIDATED = """\
No measurement of a whirling string stands behind this run: onset, whirl frequency and radii are what the model gives \
for this scene. The scene's provenance says which of its numbers are measured, published or estimated; the estimated \
ones (damping, drag, wall friction, bow, ramps) decide when whirl begins and how fast it turns.
The error of this run's element count and step was not measured in this run; compare with a run of more elements and a \
smaller step before relying on a third digit.
After the onset the motion can be chaotic: two runs that differ in anything share their statistics (onset, frequency, \
largest radius), not their paths.
The marks move with the string and have no mass of their own; their positions are exact, without \
the errors of instruments.
""".splitlines()
"""Limits of validity, below the figures of the page."""


def findings(summary: Summary) -> Iterator[Row]:
    """Rows of the findings, most important first, after what run and which time they are of."""
    if summary["runs"] > 1:
        last = ", the last" * (summary["run"] == summary["runs"])
        yield "run", f"{summary['run']} of {summary['runs']} in the bag{last}; --run N chooses another"
    if summary["start_utc"]:
        yield "times", f"in seconds from {summary['start_utc']} UTC"
    if not summary["whirl_observable"]:
        yield "rotation", rotation(summary)
        for rows in (load_rows, surface_rows, severity_rows, fatigue_rows, bit_rows):
            yield from rows(summary)
        return
    yield "motion that lasts", lasting(summary)
    yield "onset of whirl", onset_text(summary)
    yield "whirl frequency", frequency_text(summary)
    if summary["spectrum_lines"]:
        yield "lines of the spectrum", _lines(summary)
    yield "whirl ratio", number_text(summary["whirl_ratio"], "{:+.3f}", "none")
    yield "rotation", rotation(summary)
    for mark in summary["max_radius_m"]:
        yield f"largest radius, {mark}", radius_text(summary, mark)
    for rows in (_wall, load_rows, severity_rows, fatigue_rows):
        yield from rows(summary)
    yield "motion at the end", summary["motion"][-1]["state"] if summary["motion"] else "unknown"
    yield from bit_rows(summary)
    yield from sub_rows(summary)


def _wall(summary: Summary) -> Iterator[Row]:
    """Row on the penetration of the wall."""
    if (found := summary.get("wall")) and found["deepest_m"] > 0.0:
        units = units_of(summary)
        share = f"{found['deepest_m'] / found['clearance_m']:.1%} of the clearance"
        still = found["static_m"]
        at_rest = "" if still is None else f"; {units.text(still, 'offset')} at rest"
        place = f"{units.text(found['distance_from_bit_m'], 'length')} from the bit at {found['time_s']:.2f} s"
        yield "depth into the wall", f"{units.text(found['deepest_m'], 'offset')} ({share}), {place}{at_rest}"


def timeline_rows(periods: Sequence[Mapping[str, Any]]) -> list[tuple[str, str, str, str]]:
    """Rows of start, end, state and criterion of motion states."""
    return [(f"{one['start_s']:.2f} s", f"{one['end_s']:.2f} s", one["state"], one["criterion"]) for one in periods]


def mark_rows(summary: Summary) -> Iterator[tuple[str, str, str, str]]:
    """Rows of mark, its largest radius, the time since which it is over the threshold, and its motion at the end."""
    for mark in summary["max_radius_m"]:
        onset, motion = summary["mark_onset_s"].get(mark), summary["mark_motion"].get(mark)
        yield (
            mark,
            radius_text(summary, mark),
            "never" if onset is None else f"from {onset:.2f} s",
            motion[-1]["state"] if motion else "unknown",
        )


def provenance(summary: Summary) -> Iterator[Row]:
    """Rows on the run: scene, resolution, speed, version; of a recording that is no run, only the known ones."""
    is_run = bool(summary["version"])
    steps = "{steps}, halved {cut_steps} times, {steps_above_tolerance} above the tolerance"
    rows = {
        "scene": _text(summary["scene"]),
        f"{'simulated' if is_run else 'recorded'} time": "{duration_s:.2f} s, {samples} samples".format_map(summary),
        "real-time factor": number_text(summary["realtime_factor"], "{:.3g}"),
        "speed of the physics alone": number_text(summary["physics_speed"], "{:.3g} x real time"),
        "elements": _text(summary["elements"]),
        "time step": number_text(summary["step_s"], "{:.3g} s"),
        "steps": steps.format_map(summary).replace("None", "unknown"),
        "effects": ", ".join(summary["effects"]),
        **{key: _text(summary[key]) for key in ("seed", "pace", "started")},
        "drill_twin": _text(summary["version"]),
        "live analysis": _live(summary["live"]),
    }
    if summary["steps"] is None:
        del rows["steps"]
    yield from (row for row in rows.items() if is_run or row[1] not in {"", "unknown", "none recorded"})


def column_rows(summary: Summary) -> Iterator[Row]:
    """Columns of a record, and what is done with each."""
    for one in summary.get("columns", ()):
        taken = f"taken as {one['channel']} in {one['unit']}" if one["channel"] else f"left out: {one['why']}"
        yield one["column"], "; ".join((taken, *(f"no measurement: {text}" for text in one["left_out"])))


def limitations(summary: Summary) -> list[str]:
    """Sentences on what limits the findings: notes, damage, samples left out."""
    lines = list(summary["notes"])
    if summary["truncated"]:
        lines.insert(0, f"the bag is not whole: {'; '.join(summary['damage'])}")
    quality = summary["quality"]
    counted = (
        ("duplicate", "samples twice"), ("late", "samples out of order"),
        ("incomplete", "samples without position or rotation"), ("missing_marks", "marks missing in samples"),
        ("gaps", "gaps in time"),
    )  # fmt: skip
    if parts := [f"{quality[key]} {words}" for key, words in counted if quality.get(key)]:
        lines.append(f"left out of the analysis: {', '.join(parts)}")
    return lines


def transient(summary: Summary) -> bool:
    """True where the string whirled and whirls no more at the end."""
    return summary["onset_s"] is not None and summary["whirl_end_s"] is not None


def irregular(summary: Summary) -> bool:
    """True where the motion that lasts is irregular whirl, which has no single frequency."""
    return summary["onset_s"] is not None and summary["lasting_motion"] == MotionState.IRREGULAR.value


def lasting(summary: Summary) -> str:
    """Motion that lasts in words, with its name in the field, and the marks' motion where it differs in kind."""
    state = _text(summary["lasting_motion"])
    if state in FIELD_NAMES:
        return f"{state} ({FIELD_NAMES[state]})"
    if state not in _OF_THE_STRING or not summary["mark_motion"]:
        return state
    marks = sorted({periods[-1]["state"] for periods in summary["mark_motion"].values() if periods})
    return f"{state}, the shape of the string (its marks at the end: {', '.join(marks)})"


def onset_text(summary: Summary) -> str:
    """Onset of whirl in words."""
    if summary["onset_s"] is None:
        return no_onset(summary)
    if summary.get("onset_at_start"):
        first = "; a sub is analysed from its first revolutions at a steady speed" if summary.get("sub") else ""
        return (
            f"before {summary['onset_s']:.2f} s: there from the start of what is analysed, at "
            f"{summary['onset_mark']}{first}"
        )
    sure = summary.get("onset_uncertainty_s")
    known = "" if sure is None else f" +- {sure:.2f} s"
    if not summary.get("onset_dated", True):
        known += ", not dated within a revolution"
    end = summary["whirl_end_s"]
    ended = f"; a transient: no whirl since {end:.2f} s (seen live revolutions later)" if transient(summary) else ""
    return f"{summary['onset_s']:.2f} s{known}, first at {summary['onset_mark']}{ended}"


def no_onset(summary: Summary) -> str:
    """Meaning of a run in which no onset was found."""
    rate, slowest = summary["quality"].get("samples_per_revolution"), (summary.get("sub") or {}).get("slowest_hz")
    if rate is not None and rate < criteria.FEWEST_SAMPLES:
        return f"not observable: {rate:.1f} samples in a revolution, {criteria.FEWEST_SAMPLES:g} are needed"
    return "none found" if slowest is None else f"none found; a whirl slower than {slowest:.2g} Hz shows in no reading"


def interval(summary: Summary) -> str:
    """Interval of the whirl frequency as text; empty where the whirl is too short."""
    found = summary["whirl_frequency_interval_hz"]
    return "" if found is None else f"{found[0]:+.3f} to {found[1]:+.3f} Hz"


def frequency_text(summary: Summary) -> str:
    """Whirl frequency in words."""
    frequency, changes = summary["whirl_frequency_hz"], summary["whirl_frequency_changes"]
    if irregular(summary):
        over = f": {found} in windows, at {summary['frequency_mark']}" if (found := interval(summary)) else ""
        return f"no single one, the motion is irregular{over}"
    if frequency is None:
        return "none"
    begin, end = summary["whirl_frequency_window_s"]
    while_it_lasted = ", while it lasted" if transient(summary) else ""
    unsettled = {True: "; still changing", False: ""}.get(changes, "; too short to tell whether it has settled")
    spread = f", {interval(summary)} {'in windows' if unsettled else 'in nine of ten cases'}" * bool(interval(summary))
    return (
        f"{frequency:+.3f} Hz ({'forward' if frequency > 0.0 else 'backward'}){spread}, at {summary['frequency_mark']} "
        f"from {begin:.2f} to {end:.2f} s{while_it_lasted}{unsettled}"
    )


def _lines(summary: Summary) -> str:
    """Lines of the spectrum, highest first."""
    lines = (
        f"{line['frequency_hz']:+.2f} Hz ({units_of(summary).text(line['radius_m'], 'offset')})"
        for line in summary["spectrum_lines"]
    )
    return f"{', '.join(lines)}, at {summary['frequency_mark']}"


def rotation(summary: Summary) -> str:
    """Rotation as text: the top drive's as `applied`; without a top drive's, the mean of the string."""
    applied_speed, found, units = summary["applied"]["rotation_rad_s"], summary["rotation_rev_s"], units_of(summary)
    if applied_speed is not None:
        return units.text(applied_speed["mean"], "rotation")
    return "unknown" if found is None else units.text(math.tau * found, "rotation")


def radius_text(summary: Summary, mark: str) -> str:
    """Largest radius of a mark as text, with its share of the clearance."""
    value, clearance, units = summary["max_radius_m"][mark], summary["clearance_m"].get(mark), units_of(summary)
    if value is None:
        return "not seen"
    if not clearance:
        return units.text(value, "offset")
    if value > ON_THE_WALL * clearance:
        return f"{units.text(value, 'offset')} (on the wall, {value / clearance - 1.0:.1%} of the clearance into it)"
    return f"{units.text(value, 'offset')} ({value / clearance:.0%} of the clearance)"


def _live(live: Mapping[str, Any]) -> str:
    if not live["messages"]:
        return "none recorded"
    if live["differing"]:
        return f"{live['differing']} of {live['messages']} findings differ from this analysis"
    return f"the same, byte for byte ({live['messages']} findings)"


def _text(value: object) -> str:
    return "unknown" if value is None else str(value)
