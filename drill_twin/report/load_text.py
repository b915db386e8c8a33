# SPDX-License-Identifier: Apache-2.0
"""Rows of a summary on what a record tells, loads, fatigue, bit and downhole sub; the text of numbers with units."""

from collections.abc import Iterator, Mapping
from typing import Any

from drill_twin.core.severity import WORDS, Grade, told, value_text, whose_bounds
from drill_twin.core.units.system import UnitSystem, unit_system
from drill_twin.whirl.motion.stick_slip_index import FULL, MODERATE, TIME_BASE

Summary = Mapping[str, Any]
Row = tuple[str, str]

_STRETCHES = 5
"""Most periods of stick-slip that are listed."""
_MOST = 0.95
"""Share of a record from which a verdict is of all of it."""
_VARIES = 0.05
"""Range of a set-point, over its mean, from which a sentence gives the range."""


def applied(summary: Summary) -> str:
    """Sentence on weight on bit and rotation as they were applied."""
    found = summary["applied"]
    weight, speed = found["weight_on_bit_n"], found["rotation_rad_s"]
    parts = []
    if weight is not None:
        top = " (load applied at the top: the weight of the string adds to it)" if summary["load_at"] == "top" else ""
        parts.append(f"weight on bit {_over_time(summary, weight, 'force')}{top}")
    if speed is not None:
        parts.append(f"top drive at {_over_time(summary, speed, 'rotation')}")
    when = "While it stuck" if summary.get("spans") else f"From {summary['settled_s']:.1f} s on"
    return f"{when}: {', '.join(parts) or 'no weight and no speed were recorded'}."


def _over_time(summary: Summary, found: Mapping[str, float], quantity: str) -> str:
    """Mean with its unit, and the range where it is wider than a twentieth."""
    units = units_of(summary)
    varies = found["max"] - found["min"] > _VARIES * abs(found["mean"])
    over = f" on average, {units.span(found['min'], found['max'], quantity)}" if varies else ""
    return units.text(found["mean"], quantity) + over


def answers(summary: Summary) -> Iterator[Row]:
    """Five rows on a recording without marks: did it stick, did it whirl, how much, when, at which weight and speed."""
    if not (found := summary.get("surface")):
        return
    index, most, spans = found["stick_slip_index_by_torque"], summary["largest_stick_slip_index"], found["spans"]
    seen, total = found["watched_s"], found["duration_s"]
    part = "" if seen >= _MOST * total else f" in the {seen:.0f} of {total:.0f} s with torque at steady rotation"
    by, sure = "torque and string", "likely" if spans else "no"
    if most is not None:
        by, part = "the speed of the bit", ""
        sure = "yes" if spans else "no" if most < MODERATE else "no, but the bit swings"
    elif index is None:
        more = ("", " has too few samples")["bit speed" in found["channels"]]
        by = f"the torque; the speed of the bit{more or ', or the string (--scene), tells more'}"
    elif not spans and MODERATE <= index < FULL:
        sure = "no, but the bit swings"
    sure += f",{part}" * bool(part and not spans)
    yield "did it stick", f"unknown: {found['unknown']}" if found["unknown"] else f"{sure}, by {by}"
    yield "did it whirl", "not observable: no channel of the surface shows sideways motion; a downhole sub does"
    told = number_text(
        index, "index up to about {:.2f} (less with friction along the string)", "stick-slip index unknown"
    )
    told = number_text(most, "index {:.2f} at most", told)
    if swing := found["torque_swing"]:
        period = f" every {swing['period_s']:.2f} s" if swing["period_s"] and spans else ""
        size = units_of(summary).text(swing["largest_nm"], "torque")
        told += f"; the torque swings by {size} at most{period}, {swing['largest']:.2f} of its mean"
    yield "how much", told
    shown = "".join(f"{'about ' * (most is None)}{start:.1f} to {end:.1f} s, " for start, end in spans[:_STRETCHES])
    total = f"{shown}{sum(end - start for start, end in spans):.0f} s in all"
    yield "when", total if spans else "unknown" if found["unknown"] else f"never{part}"
    yield "at which weight and speed", applied({**summary, **found})


def load_rows(summary: Summary) -> Iterator[Row]:
    """Rows on weight on bit, hookload, torque and drag; the torque of the bit is positive where it resists."""
    units = units_of(summary)
    for name, key, quantity, sign in (
        ("weight on bit", "weight_on_bit_n", "force", 1.0),
        ("hookload", "hookload_n", "force", 1.0),
        ("drag", "drag_n", "force", 1.0),
        ("torque of the top drive", "top_drive_torque_nm", "torque", 1.0),
        ("torque on the bit", "bit_torque_nm", "torque", -1.0),  # the summary holds the rock's torque on the bit
    ):
        if found := summary["loads"].get(key):
            mean, *ends = (sign * found[kind] + 0.0 for kind in ("mean", "min", "max"))  # never -0
            over = units.span(min(ends), max(ends), quantity)
            yield name, f"{units.text(mean, quantity)} on average from {summary['settled_s']:.1f} s on, {over} in all"


def severity_rows(summary: Summary) -> Iterator[Row]:
    """Rows on severity with what decided it, its quantities, wear, and drilling."""
    units = units_of(summary)
    if summary["severity"]:
        yield "severity", told(summary["severity"], units)
    unknown: dict[str, list[str]] = {}
    for quantity, words in WORDS.items():
        if (row := summary["severity_by_quantity"].get(quantity)) is None or quantity == "stick_slip":
            continue
        if row["value"] is None:
            unknown.setdefault(row["why"], []).append(words.replace(",", ""))
            continue
        value = value_text(quantity, row["value"], units)
        more = f" at {row['place']}" * bool(row["place"])
        if (far := row["distance_from_bit_m"]) is not None:
            more += f", {units.text(far, 'length')} from the bit"
        if quantity == "bending_stress" and (cycles := summary["bending_cycles_per_second"]) is not None:
            more += f", {cycles:.2g} cycles a second"
        yield words, f"{value}{more}{_grade_text(row)}"
    yield from (("unknown", f"{', '.join(names)} ({why})") for why, names in unknown.items())
    if wear := {mark: power for mark, power in summary["wear_power_w"].items() if power is not None}:
        worst = max(wear, key=lambda mark: wear[mark])
        yield "wall force times sliding", f"{wear[worst]:.3g} W on average at {worst}: not graded, no bound is known"
    if summary["severity"]:
        yield "bounds of severity", whose_bounds(summary["severity_source"], summary["units"])
    assumed = ", of the rock that the scene assumes" if summary["version"] else ""
    if summary["rate_of_penetration_m_s"] is not None:
        yield "rate of penetration", f"{units.text(summary['rate_of_penetration_m_s'], 'rate', '.3g')}{assumed}"
    if summary["specific_energy_pa"] is not None:
        yield "specific energy", f"{units.text(summary['specific_energy_pa'], 'stress', '.3g')} (Teale){assumed}"


def _grade_text(row: Mapping[str, Any]) -> str:
    """Grade of a quantity, and what else than its value decided it."""
    grade = "not graded" if row["grade"] is None else Grade(row["grade"]).word
    return f": {grade}{row['why'] and ' (' + row['why'] + ')'}"


def surface_rows(summary: Summary) -> Iterator[Row]:
    """Rows on the weight of the block, gaps and spikes of the surface channels."""
    if not (found := summary.get("surface")):
        return
    if block := summary.get("block"):
        told = 'unknown: no time that is surely in slips; drag needs it, as --channel "block_weight=32 klbf"'
        if (weight := block["weight_n"]) is not None:
            at = "given" if block["at_s"] is None else f"lowest steady one at rest, as in slips, {block['at_s']:.1f} s"
            told = f"{units_of(summary).text(weight, 'force')} of the hookload ({at})"
        yield "block and top drive", told
    for name, channel in found["channels"].items():
        lost, odd = channel["gaps"], channel["spikes"]
        if lost or odd:
            longest = max(lost, key=lambda gap: gap[1] - gap[0], default=None)
            gap = f", the longest from {longest[0]:.2f} to {longest[1]:.2f} s" if longest else ""
            spike = f", the first at {odd[0]:.2f} s; not in the figures above" if odd else ""
            yield f"gaps, {name}", f"gaps: {len(lost)}{gap}; samples in spikes: {len(odd)}{spike}"
    if not any(channel["gaps"] or channel["spikes"] for channel in found["channels"].values()):
        yield "gaps and spikes", "none"


def fatigue_rows(summary: Summary) -> Iterator[Row]:
    """Rows on stress and damage of the sections of `fatigue`."""
    for name, found in (summary.get("fatigue") or {}).items():
        life = found["seconds_to_damage_1"]
        yield (
            f"stress at {name}",
            (
                f"at most {units_of(summary).text(found['largest_stress_pa'], 'stress')} "
                f"({found['share_of_yield']:.0%} of yield), "
                f"{found['cycles']:g} cycles, {number_text(found['cycles_per_second'], '{:.3g}')} a second at the end"
            ),
        )
        later = f"none from {summary['settled_s']:.1f} s on"
        later = later if life is None else f"1 after {duration_text(life)} of such motion"
        yield f"damage at {name}", f"{found['damage']:.3g}; {later}"


def duration_text(seconds: float) -> str:
    """Time [s] as text in the unit that it is spoken of in."""
    for size, unit in ((31_557_600.0, "years"), (86_400.0, "days"), (3_600.0, "hours"), (60.0, "minutes")):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds:.3g} s"


def bit_rows(summary: Summary) -> Iterator[Row]:
    """Rows on the rotation of the bit."""
    before = f"; stick-slip until {summary['stick_slip'][-1]['end_s']:.2f} s" if summary["stick_slip"] else ""
    yield "bit at the end", f"{summary['bit']}{before}"
    row, most = summary["severity_by_quantity"].get("stick_slip"), summary["largest_stick_slip_index"]
    if row or most is not None:
        last = value_text("stick_slip", summary["stick_slip_index"], units_of(summary))
        over = (
            "" if most is None else f" over the last {min(TIME_BASE, summary['duration_s']):.3g} s, {most:.3g} at most"
        )
        yield "stick-slip index", f"{last}{over}{_grade_text(row) if row else ''}"
    for stretch in summary["stick_slip"][:_STRETCHES]:
        yield (
            "stick-slip",
            (
                f"{stretch['start_s']:.2f} to {stretch['end_s']:.2f} s: {stretch['cycles']} cycles of "
                f"{stretch['shortest_s']:.3f} to {stretch['longest_s']:.3f} s ({stretch['frequency_hz']:.2f} Hz), "
                f"index {stretch['severity']:.2f}"
            ),
        )
    if len(summary["stick_slip"]) > _STRETCHES:
        yield "", f"and {len(summary['stick_slip']) - _STRETCHES} more stretches of stick-slip"
    if summary["stick_slip"] and summary["bit_spectral_peak_hz"] is not None:
        yield "spectral peak of the bit", f"{summary['bit_spectral_peak_hz']:.2f} Hz"


def sub_rows(summary: Summary) -> Iterator[Row]:
    """Rows on what a downhole sub tells beside whirl."""
    if not (found := summary.get("sub")):
        return
    if found["share_at_rest"] is not None:
        yield "section at rest", f"{found['share_at_rest']:.0%} of the time of stick-slip"
    hard = ""
    if found["largest_impact"] is not None:
        mean, most = (
            units_of(summary).text(found[f"{size}_impact"], "acceleration", ".3g") for size in ("mean", "largest")
        )
        hard = f" ({found['impact_rate_hz']:.2f} a second), acceleration {mean} on average, {most} at most"
    yield "impacts on the wall", f"{found['impacts']}{hard}"


def units_of(summary: Summary) -> UnitSystem:
    """Units in which people read a summary."""
    return unit_system(summary["units"])


def number_text(value: float | None, form: str, none: str = "unknown") -> str:
    """Number in a format, as "{:.2f} Hz"; another word for None."""
    return none if value is None else form.format(value)
