# SPDX-License-Identifier: Apache-2.0
"""Tables of the reproduction, for the terminal and the page."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from drill_twin.core.table import Table
from drill_twin_evidence.paper.runs.cases import Case
from drill_twin_evidence.paper.runs.full_size import FullSizeRow
from drill_twin_evidence.paper.runs.reproduction import Reproduction
from drill_twin_evidence.paper.runs.run import Measured
from drill_twin_evidence.paper.runs.table import Row

Cells = tuple[str, ...]

CAPTIONS = {
    "paper_speed": "Red: published.",
    "paper_load": "Red: published.",
    "paper_displacement": "Red: published. Blue and orange: ours.",
    "paper_paths": "The circle is the wall; a mark on the rod's surface stays within it.",
    "paper_spectra": "Each line is scaled to its highest peak.",
    "paper_motion": "What the analyzer saw. The paper's order: rotation about a fixed axis, forward whirl, rolling "
    "along the wall, second bending, irregular rotation, reverse whirl, spiral.",
    "paper_full_size": "Red: published velocities. Orbits of the centre line at the near-bit mark.",
}
"""Caption of each figure."""


def lead(done: Reproduction) -> str:
    """Result of the reproduction in a sentence."""
    near, right = sum(row.near for row in done.rows), sum(trend.right for trend in done.trends)
    sentence = (
        f"{near} of {len(done.rows)} published numbers of the bench within 20 %, "
        f"{right} of {len(done.trends)} trends right, with one set of parameters for all runs"
    )
    if done.full_size:
        sentence += f"; {sum(row.near for row in done.full_size)} of {len(done.full_size)} of the full-size assembly"
    return sentence + "."


def tables(done: Reproduction) -> Iterator[Table]:
    """All tables, each with its title."""
    rows = [(row.number.q, *_row(row), row.number.doubt) for row in done.rows]
    yield Table(
        ("", "quantity", "published", "ours", "off by", "within 20 %", "doubt"), rows, title="Numbers", right=(2, 3, 4)
    )
    trends = [(trend.published, trend.ours, _yes(trend.right)) for trend in done.trends]
    yield Table(("published trend", "ours", "right"), trends, title="Trends")
    yield Table(
        ("run", "critical time", "whirl", "over rotation", "line of mark-2", "largest mark-3, -2, -1", "motion"),
        map(_run, sorted(done.measured.items())),
        title="All runs",
        right=(1, 2, 3, 4),
    )
    if done.variants:
        variants = [
            (result.variant.name if number == 0 else "", *_row(row))
            for result in done.variants
            for number, row in enumerate(result.rows)
        ]
        yield Table(
            ("reading", "quantity", "published", "ours", "off by", "within 20 %"),
            variants,
            title="Other readings of the bench",
            right=(2, 3, 4),
        )
    scales = [(scale.what, scale.rod, scale.field, scale.why) for scale in done.scales]
    yield Table(("quantity", "rod", "field", "by"), scales, title="Rod and field")
    if done.full_size:
        yield Table(
            ("", "quantity", "published", "ours", "within 20 %"),
            map(_full_size, done.full_size),
            title="The full-size assembly, a stand-in",
            right=(2, 3),
        )
        disorder = [
            (f"{row.speed:g} r/min", f"{row.entropy:.3f}", f"{row.lyapunov:+.2f} 1/s", f"{row.per_turn:+.2f}")
            for row in done.disorder
        ]
        yield Table(
            ("speed", "entropy of the near-bit orbit", "largest Lyapunov exponent", "per revolution"),
            disorder,
            title="Disorder at 180 kN",
            right=(1, 2, 3),
        )


def page(done: Reproduction, figures: Iterable[str]) -> str:
    """The result as Markdown: tables, figures that lie beside it, and the bench as it was run."""
    parts = [lead(done)]
    for table in tables(done):
        parts += [f"### {table.title}", table.markdown()]
    parts += [f"![{name.replace('_', ' ')}]({name}.png)  \n{CAPTIONS[name]}" for name in figures]
    return "\n\n".join([*parts, f"### The bench, as it was run\n\n```yaml\n{done.scene.to_yaml()}```"]) + "\n"


def _row(row: Row) -> Cells:
    number = row.number
    unit = f" {number.unit}" if number.unit else ""
    return (
        number.name,
        f"{number.value:g}{unit}",
        "none" if row.ours is None else f"{row.ours:.3g}{unit}",
        "" if row.deviation is None else f"{row.deviation:+.0%}",
        _yes(row.near),
    )


def _run(item: tuple[Case, Measured]) -> Cells:
    case, found = item
    states = list(dict.fromkeys(state for _, state in found.motion))
    return (
        str(case),
        _number(found.onset_s, "{:.2f} s"),
        _number(found.frequency_hz, "{:+.2f} Hz"),
        _number(found.ratio, "{:+.2f}"),
        _number(found.line_hz, "{:.2f} Hz"),
        " ".join(f"{found.largest_mm[mark]:.0f}" for mark in ("mark_3", "mark_2", "mark_1")) + " mm",
        ", ".join(states) + (f"; {found.failure}" if found.failure else ""),
    )


def _full_size(row: FullSizeRow) -> Cells:
    number = row.number
    ours = "none" if row.ours is None else _range(*row.ours, number.unit)
    return number.q, number.what, _range(number.low, number.high, number.unit), ours, _yes(row.near)


def _range(low: float, high: float, unit: str) -> str:
    return f"{low:.3g} {unit}" if low == high else f"{low:.3g} to {high:.3g} {unit}"


def _number(value: float | None, form: str) -> str:
    return "none" if value is None else form.format(value)


def _yes(truth: bool) -> str:
    return "yes" if truth else "no"
