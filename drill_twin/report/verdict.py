# SPDX-License-Identifier: Apache-2.0
"""Verdict on a run or a record: sentences on whirl, severity and what to do next, and the five rows that matter."""

from collections.abc import Iterator
from itertools import islice

from drill_twin.core.severity import Grade, told
from drill_twin.report.load_text import Row, Summary, answers, applied, units_of
from drill_twin.report.text import findings, irregular, no_onset, transient
from drill_twin.whirl import MotionState
from drill_twin.whirl.criteria import CONTACT_RADIUS, SUSTAIN

_DOES = {
    MotionState.AT_REST: "does not turn", MotionState.FIXED_AXIS: "turns about a fixed axis",
    MotionState.PLANE_SWING: "swings in a plane, which is no whirl",
    MotionState.SYNCHRONOUS_WHIRL: "bows out and turns with the rotation (synchronous whirl)",
    MotionState.FORWARD_WHIRL: "whirls forward", MotionState.BACKWARD_WHIRL: "whirls backward",
    MotionState.ROLLING: "rolls backward along the wall", MotionState.CREEPING: "creeps along the wall, slipping",
    MotionState.SECOND_BENDING: "whirls in a plane shape on both sides of the axis (second bending)",
    MotionState.SPIRAL: "whirls in the shape of a helix", MotionState.IRREGULAR: "whirls irregularly (chaotic whirl)",
    MotionState.IMPACTS: "strikes the wall again and again",
}  # fmt: skip
_ON_THE_WALL = {MotionState.ROLLING, MotionState.CREEPING, MotionState.IMPACTS}
"""States whose words say that the string touches the wall."""
_STUCK = {
    "yes": "The bit stuck and slipped", "likely": "The bit probably stuck and slipped", "no": "No stick-slip was found",
}  # fmt: skip
_FAR = 0.5
"""Radius over the clearance from which a string without whirl is said to be off the axis: chosen, not measured."""
_NAMED = 3
"""Marks at the wall that are named; more are counted."""
_ROWS = 5


def verdict(summary: Summary, bag: str = "") -> list[str]:
    """Sentences on a summary: what the string or the bit does, how severe it is, and the command that finds the cause.

    Args:
        summary: Summary of a run or a record.
        bag: Its path, for the command; empty: none is named.
    """
    severity, units = summary["severity"], units_of(summary)
    which = f"Run {summary['run']} of {summary['runs']}. " * (summary["runs"] > 1)
    which += "The bag is not whole. " * bool(summary["truncated"])
    found = [which + (_whirl(summary) if summary["whirl_observable"] else _torsion(summary))]
    found.append(f"Severity {told(severity, units)}." if severity else "Severity unknown: nothing has a grade.")
    matters = summary["onset_s"] is not None or (severity and severity["grade"] >= Grade.MEDIUM)
    computable = bag and summary["scene"] and summary["version"] and "cause" not in summary
    if matters and computable:
        found.append(f"The cause is not computed yet: drill-twin analyze {bag} --why")
    return found


def first_rows(summary: Summary) -> Iterator[Row]:
    """Rows that come before all others: which run and time, then onset, frequency, largest radius, stick-slip index,
    bounds of severity and set-points; of the record of a rig its answers.
    """
    rows = list(findings(summary))
    yield from (row for row in rows if row[0] in {"run", "times"})
    if not summary["whirl_observable"]:
        yield from islice(answers(summary) if summary.get("surface") else rows, _ROWS)
        return
    radius = f"largest radius, {(widest(summary) or [''])[0]}"
    first = {"onset of whirl", "whirl frequency", radius, "stick-slip index", "bounds of severity"}
    yield from (row for row in rows if row[0] in first)
    yield "set-points", applied(summary).removesuffix(".")


def _whirl(summary: Summary) -> str:
    lasting, onset, ended = summary["lasting_motion"], summary["onset_s"], transient(summary)
    state = MotionState(lasting) if lasting else MotionState.NOT_OBSERVABLE
    does = f"the string {_DOES[state]}" if state in _DOES else "its motion at the end is not observable"
    if onset is None:
        if (why := no_onset(summary)) != "none found":
            return f"Whirl: {why}."
        turns = abs(summary["rotation_rev_s"] or 0.0) * summary["duration_s"]
        if turns < SUSTAIN:
            return f"Whirl: not known, as the string turned {turns:.2g} times in {summary['duration_s']:.3g} s."
        return f"No whirl was found in {summary['duration_s']:.3g} s: {does}{_bent(summary)}."
    when = "from the start of what was analysed" if summary.get("onset_at_start") else f"from {onset:.2f} s"
    if ended:
        return f"Whirl {when} to {summary['whirl_end_s']:.2f} s, and none since: {does}."
    frequency = summary["whirl_frequency_hz"]
    if frequency is not None and not irregular(summary):
        way = "" if "ward" in does else f", {'forward' if frequency > 0.0 else 'backward'}"
        changes = ", still changing" * bool(summary["whirl_frequency_changes"])
        does += f"{way} at {abs(frequency):.2f} Hz{changes}"
    return f"Whirl {when}: {does}{_at_the_wall(summary) if state not in _ON_THE_WALL else ''}."


def _bent(summary: Summary) -> str:
    """Clause on a string that was far off the axis though it did not whirl; empty where it was not."""
    if (found := widest(summary)) is None or not (room := summary["clearance_m"].get(found[0])):
        return ""
    mark, radius = found
    if radius >= CONTACT_RADIUS * room:
        return f"; {mark} touched the wall"
    return f"; {mark} was up to {radius / room:.0%} of the clearance off the axis" if radius > _FAR * room else ""


def _at_the_wall(summary: Summary) -> str:
    """Clause on the marks that were in contact with the wall; empty where none was."""
    radii, room = summary["max_radius_m"], summary["clearance_m"]
    marks = [
        mark for mark, radius in radii.items() if room.get(mark) and (radius or 0.0) >= CONTACT_RADIUS * room[mark]
    ]
    if not marks:
        return ""
    names = ", ".join(marks) if len(marks) <= _NAMED else f"{len(marks)} of {len(radii)} marks"
    return f"; {names} reached the wall"


def _torsion(summary: Summary) -> str:
    found = dict(answers(summary))
    if not found:
        return f"The record shows no sideways motion; the bit at its end: {summary['bit']}."
    answer, _, why = found["did it stick"].partition(",") if "unknown:" not in found["did it stick"] else ("", "", "")
    stuck = _STUCK.get(answer) or f"Whether the bit stuck and slipped is {found['did it stick']}"
    return f"{stuck}{f',{why}' if why else ''}. Whirl does not show in a record of the surface."


def widest(summary: Summary) -> tuple[str, float] | None:
    """Mark with the largest radius over its clearance, and this radius [m]; None where none was seen."""
    radii = {mark: radius for mark, radius in summary["max_radius_m"].items() if radius is not None}
    room = summary["clearance_m"]
    mark = max(radii, key=lambda mark: radii[mark] / (room.get(mark) or 1.0), default=None)
    return None if mark is None else (mark, radii[mark])
