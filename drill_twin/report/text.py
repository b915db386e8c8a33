# SPDX-License-Identifier: Apache-2.0
"""Summary as text: rows of the tables of the command line and the page, and the limits of validity."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

from drill_twin.whirl import MotionState
from drill_twin.whirl.motion.stick_slip_index import TIME_BASE

Summary = Mapping[str, Any]
Row = tuple[str, str]

_OF_THE_STRING = {MotionState.SPIRAL.value, MotionState.SECOND_BENDING.value}
"""States that only the string has, by its shape."""
KILO = 5000.0
"""Force [N], torque [N m] or force per length [N/m] from which the unit has a k before it."""
ON_THE_WALL = 1.005
"""Share of the clearance from which the penetration of the wall is told."""
_VARIES = 0.05
"""Range of a set-point, over its mean, from which it is given."""
_STRETCHES = 5
"""Most periods of stick-slip with a row of their own."""

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


def applied(summary: Summary) -> str:
    """Sentence on weight on bit and rotation as they were applied."""
    found = summary["applied"]
    weight, speed = found["weight_on_bit_n"], found["rotation_rad_s"]
    parts = []
    if weight is not None:
        parts.append(f"weight on bit {_over_time(weight, 'N')}{_at_top(summary)}")
    if speed is not None:
        turns = {key: value / math.tau for key, value in speed.items()}
        parts.append(f"top drive at {_over_time(turns, 'rev/s')} ({_over_time(turns, 'rpm', 60.0)})")
    of = "run" if summary["scene"] else "recording"
    return f"Second half of the {of}: {', '.join(parts) or 'no weight and no speed were recorded'}."


def _over_time(found: Mapping[str, float], unit: str, scale: float = 1.0) -> str:
    """Mean with its unit, and the range where it is wider than a twentieth."""
    mean, least, most = (scale * found[key] for key in ("mean", "min", "max"))
    if unit == "N" and max(-least, most) >= KILO:
        mean, least, most, unit = 1e-3 * mean, 1e-3 * least, 1e-3 * most, "kN"
    varies = most - least > _VARIES * abs(mean)
    return f"{mean:.4g} {unit}{f' on average, {least:.4g} to {most:.4g} {unit}' if varies else ''}"


def _at_top(summary: Summary) -> str:
    """Place at which the load is applied, if that is not the bit."""
    return " (load applied at the top: the weight of the string adds to it)" if summary["load_at"] == "top" else ""


def findings(summary: Summary) -> Iterator[Row]:
    """Rows of the findings, most important first."""
    if not summary["whirl_observable"]:
        yield "whirl", "not observable: no positions of marks"
        yield "rotation", _number(summary["rotation_rev_s"], "{:.3f} rev/s")
        yield from load_rows(summary)
        yield from _fatigue(summary)
        yield from _bit(summary)
        return
    yield "motion that lasts", _lasting(summary)
    yield "onset of whirl", _onset(summary)
    yield "whirl frequency", _frequency(summary)
    if summary["spectrum_lines"]:
        yield "lines of the spectrum", _lines(summary)
    yield "precession / rotation", _ratio(summary)
    yield "rotation", _number(summary["rotation_rev_s"], "{:.3f} rev/s")
    for mark, value in summary["max_radius_m"].items():
        yield f"largest radius, {mark}", radius_text(value, summary["clearance_m"].get(mark))
    yield from _states(summary)
    yield from _wall(summary)
    yield from load_rows(summary)
    yield from _fatigue(summary)
    yield "motion at the end", summary["motion"][-1]["state"] if summary["motion"] else "unknown"
    yield from _bit(summary)
    yield from _sub(summary)


def _states(summary: Summary) -> Iterator[Row]:
    """Rows on the steady whirls near the findings, where they were asked for."""
    found = summary.get("whirl_states") or {}
    for one in found.get("findings", ()):
        yield f"{one['finding']}: state", one["sentence"]
    if "conclusion" in found:
        yield "why this whirl", found["conclusion"]
    for note in found.get("notes", ()):
        yield "whirl states", note


def _wall(summary: Summary) -> Iterator[Row]:
    """Row on the penetration of the wall."""
    found = summary.get("wall")
    if found and found["deepest_m"] > 0.0:
        share = f"{found['deepest_m'] / found['clearance_m']:.1%} of the clearance"
        at_rest = "" if found["static_m"] is None else f"; its load at rest gives {millimetres(found['static_m'])}"
        place = f"{found['distance_from_bit_m']:.4g} m from the bit at {found['time_s']:.2f} s"
        yield "deepest in the wall", f"{millimetres(found['deepest_m'])} ({share}), {place}{at_rest}"


def load_rows(summary: Summary) -> Iterator[Row]:
    """Rows on weight on bit, hookload, torque and drag."""
    for name, key, unit in (
        ("weight on bit", "weight_on_bit_n", "N"),
        ("hookload", "hookload_n", "N"),
        ("drag", "drag_n", "N"),
        ("torque of the top drive", "top_drive_torque_nm", "N m"),
        ("torque on the bit", "bit_torque_nm", "N m"),
    ):
        if found := summary["loads"].get(key):
            kilo = max(-found["min"], found["max"]) >= KILO
            mean, least, most = (1e-3 * found[of] if kilo else found[of] for of in ("mean", "min", "max"))
            shown = f"k{unit}" if kilo else unit
            yield name, f"{mean:.4g} {shown} on average, {least:.4g} to {most:.4g} {shown}"


def _fatigue(summary: Summary) -> Iterator[Row]:
    """Rows on stress and damage of the sections of `fatigue`."""
    for name, found in (summary.get("fatigue") or {}).items():
        life = found["seconds_to_damage_1"]
        words = (
            f"at most {1e-6 * found['largest_stress_pa']:.4g} MPa ({found['share_of_yield']:.0%} of yield), "
            f"{found['cycles']:g} cycles, {_number(found['cycles_per_second'], '{:.3g}')} a second at the end"
        )
        yield f"stress at {name}", words
        yield (
            f"damage at {name}",
            f"{found['damage']:.3g}; "
            + (
                "none in the second half of the run"
                if life is None
                else f"1 after {duration_text(life)} of such motion"
            ),
        )


def duration_text(seconds: float) -> str:
    """Time [s] as text in the unit that it is spoken of in."""
    for size, unit in ((31_557_600.0, "years"), (86_400.0, "days"), (3_600.0, "hours"), (60.0, "minutes")):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds:.3g} s"


def _bit(summary: Summary) -> Iterator[Row]:
    """Rows on the rotation of the bit."""
    yield "bit at the end", summary["bit"]
    if summary["largest_stick_slip_index"] is not None:
        last, most = (_number(summary[key], "{:.2f}") for key in ("stick_slip_index", "largest_stick_slip_index"))
        yield "stick-slip index", f"{last} over the last {TIME_BASE} s, {most} at most"
    for stretch in summary["stick_slip"][:_STRETCHES]:
        words = (
            f"{stretch['start_s']:.2f} to {stretch['end_s']:.2f} s: {stretch['cycles']} cycles of "
            f"{stretch['shortest_s']:.3f} to {stretch['longest_s']:.3f} s ({stretch['frequency_hz']:.2f} Hz), "
            f"severity {stretch['severity']:.2f}"
        )
        yield "stick-slip", words
    if len(summary["stick_slip"]) > _STRETCHES:
        yield "", f"and {len(summary['stick_slip']) - _STRETCHES} more stretches of stick-slip"
    if summary["stick_slip"] and summary["bit_spectral_peak_hz"] is not None:
        yield "spectral peak of the bit", f"{summary['bit_spectral_peak_hz']:.2f} Hz"


def _sub(summary: Summary) -> Iterator[Row]:
    """Rows on what a downhole sub tells beside whirl."""
    found = summary.get("sub")
    if not found:
        return
    if found["share_at_rest"] is not None:
        yield "section at rest", f"{found['share_at_rest']:.0%} of the time of stick-slip"
    largest = (
        ""
        if found["largest_impact"] is None
        else (
            f" ({found['impact_rate_hz']:.2f} a second), acceleration {found['mean_impact']:.3g} m/s^2 on average, "
            f"{found['largest_impact']:.3g} m/s^2 at most"
        )
    )
    yield "impacts on the wall", f"{found['impacts']}{largest}"


def provenance(summary: Summary) -> Iterator[Row]:
    """Rows on the run: scene, resolution, speed, version."""
    yield "scene", _text(summary["scene"])
    yield "simulated time", f"{summary['duration_s']:.2f} s, {summary['samples']} samples"
    yield "real-time factor", _number(summary["realtime_factor"], "{:.3g}")
    yield "speed of the physics alone", _number(summary["physics_speed"], "{:.3g} x real time")
    yield "elements", _text(summary["elements"])
    yield "time step", _number(summary["step_s"], "{:.3g} s")
    if summary["steps"] is not None:
        cut, loose = _text(summary["cut_steps"]), _text(summary["loose_steps"])
        yield "steps", f"{summary['steps']}, {cut} cut steps, {loose} loose steps"
    yield "effects", ", ".join(summary["effects"])
    yield "seed", _text(summary["seed"])
    yield "pace", _text(summary["pace"])
    yield "started", _text(summary["started"])
    yield "drill_twin", _text(summary["version"])
    yield "live analysis", _live(summary["live"])


def limitations(summary: Summary) -> list[str]:
    """Sentences on what limits the findings: notes, damage, samples left out."""
    lines = list(summary["notes"])
    if summary["truncated"]:
        lines.insert(0, f"the bag is not whole: {'; '.join(summary['damage'])}")
    quality = summary["quality"]
    counted = (
        ("duplicate", "samples twice"),
        ("late", "samples out of order"),
        ("incomplete", "samples without position or rotation"),
        ("missing_marks", "marks missing in samples"),
        ("gaps", "gaps in time"),
    )
    parts = [f"{quality[key]} {words}" for key, words in counted if quality.get(key)]
    if parts:
        lines.append(f"left out of the analysis: {', '.join(parts)}")
    return lines


def transient(summary: Summary) -> bool:
    """True where the string whirled and does so no more."""
    return summary["onset_s"] is not None and summary["whirl_end_s"] is not None


def irregular(summary: Summary) -> bool:
    """True where the motion that lasts is irregular whirl, which has no single frequency."""
    return summary["onset_s"] is not None and summary["lasting_motion"] == MotionState.IRREGULAR.value


def _lasting(summary: Summary) -> str:
    """State that lasts, with that of the marks where the string has a state of its own."""
    state = _text(summary["lasting_motion"])
    if state not in _OF_THE_STRING or not summary["mark_motion"]:
        return state
    marks = sorted({periods[-1]["state"] for periods in summary["mark_motion"].values() if periods})
    return f"{state}, the shape of the string (its marks at the end: {', '.join(marks)})"


def _onset(summary: Summary) -> str:
    if summary["onset_s"] is None:
        return "none found"
    if summary.get("onset_at_start"):
        first = "; a sub is analysed from its first revolutions at a steady speed" if summary.get("sub") else ""
        return (
            f"before {summary['onset_s']:.2f} s: there from the start of what is analysed, at {summary['onset_mark']} "
            f"(confidence {summary['onset_confidence']:.2f}){first}"
        )
    sure = summary.get("onset_uncertainty_s")
    known = "" if sure is None else f" +- {sure:.2f} s"
    if not summary.get("onset_dated", True):
        known += ", not dated within a revolution"
    ended = f"; a transient: no whirl since {summary['whirl_end_s']:.2f} s" if transient(summary) else ""
    return (
        f"{summary['onset_s']:.2f} s{known}, first at {summary['onset_mark']} "
        f"(confidence {summary['onset_confidence']:.2f}){ended}"
    )


def interval(summary: Summary) -> str:
    """Interval of the precession over windows as text; empty where the whirl is too short for two."""
    found = summary["whirl_frequency_interval_hz"]
    return "" if found is None else f"{found[0]:+.2f} to {found[1]:+.2f} Hz"


def _frequency(summary: Summary) -> str:
    frequency, mark = summary["whirl_frequency_hz"], summary["frequency_mark"]
    over = interval(summary)
    if over:
        over = f"{over} over windows of {summary['window_rev']:g} revolutions"
    if irregular(summary):
        return f"no single one, the motion is irregular{f': {over}, at {mark}' if over else ''}"
    if frequency is None:
        return "none"
    while_it_lasted = ", while it lasted" if transient(summary) else ""
    sense = "forward" if frequency > 0.0 else "backward"
    return f"{frequency:+.3f} Hz ({sense}), at {mark}{while_it_lasted}{f'; {over}' if over else ''}"


def _lines(summary: Summary) -> str:
    """Lines of the spectrum, highest first."""
    lines = (f"{line['frequency_hz']:+.2f} Hz ({millimetres(line['radius_m'])})" for line in summary["spectrum_lines"])
    return f"{', '.join(lines)}, at {summary['frequency_mark']}"


def _ratio(summary: Summary) -> str:
    """Precession over rotation, each number with its meaning."""
    names = {"mode": "most frequent", "line": "highest line of the spectrum", "mean": "mean weighted by the radius"}
    left_out = {"mode"} if irregular(summary) else set()
    found = [
        f"{value:+.3f} ({names[kind]})"
        for kind, value in summary["ratios"].items()
        if value is not None and kind not in left_out
    ]
    return ", ".join(found) or "unknown"


def radius_text(value: float | None, clearance: float | None) -> str:
    """Largest radius of a mark [m] as text, with its share of the clearance [m]."""
    if value is None:
        return "not seen"
    if not clearance:
        return millimetres(value)
    if value > ON_THE_WALL * clearance:
        return f"{millimetres(value)} (on the wall, {value / clearance - 1.0:.1%} of the clearance into it)"
    return f"{millimetres(value)} ({value / clearance:.0%} of the clearance)"


def millimetres(value: float) -> str:
    """Length [m] as text in mm."""
    return f"{1e3 * value:.1f} mm" if abs(value) >= 1e-3 else f"{1e3 * value:.2g} mm"


def _live(live: Mapping[str, Any]) -> str:
    if not live["messages"]:
        return "none recorded"
    if live["differing"]:
        return f"{live['differing']} of {live['messages']} findings differ from this analysis"
    return f"the same, byte for byte ({live['messages']} findings)"


def _number(value: float | None, form: str) -> str:
    return "unknown" if value is None else form.format(value)


def _text(value: object) -> str:
    return "unknown" if value is None else str(value)
