# SPDX-License-Identifier: Apache-2.0
"""Texts of the tables, for the terminal and the page."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from drill_twin_evidence.paper.runs.full_size import Disorder, FullSizeRow
from drill_twin_evidence.paper.runs.reproduction import Reproduction, VariantResult
from drill_twin_evidence.paper.runs.similarity import Scale
from drill_twin_evidence.paper.runs.table import Row, Trend

Cells = tuple[str, ...]

NUMBERS = ("", "quantity", "published", "ours", "off by", "within 20 %", "doubt")
TRENDS = ("published trend", "ours", "right")
RUNS = ("run", "critical time", "whirl", "over rotation", "line of mark-2", "largest mark-3, -2, -1", "motion")
VARIANT = ("reading", "quantity", "published", "ours", "off by", "within 20 %")
SCALES = ("quantity", "rod", "field", "by")
FULL_SIZE = ("", "quantity", "published", "ours", "within 20 %")
DISORDER = ("speed", "entropy of the near-bit orbit", "largest Lyapunov exponent", "per revolution")


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


def number_rows(rows: Iterable[Row]) -> Iterator[Cells]:
    """Cells under `NUMBERS`."""
    for row in rows:
        yield (row.number.q, *_row(row), row.number.doubt)


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


def trend_rows(trends: Iterable[Trend]) -> Iterator[Cells]:
    """Cells under `TRENDS`."""
    for trend in trends:
        yield trend.published, trend.ours, _yes(trend.right)


def run_rows(done: Reproduction) -> Iterator[Cells]:
    """Cells under `RUNS`."""
    for case, found in sorted(done.measured.items(), key=lambda item: (item[0].weight_on_bit, item[0].speed)):
        states: list[str] = []
        for _, state in found.motion:
            if state not in states:
                states.append(state)
        yield (
            str(case),
            _number(found.onset_s, "{:.2f} s"),
            _number(found.frequency_hz, "{:+.2f} Hz"),
            _number(found.ratio, "{:+.2f}"),
            _number(found.line_hz, "{:.2f} Hz"),
            " ".join(f"{found.largest_mm[mark]:.0f}" for mark in ("mark_3", "mark_2", "mark_1")) + " mm",
            ", ".join(states) + (f"; {found.failure}" if found.failure else ""),
        )


def variant_rows(variants: Iterable[VariantResult]) -> Iterator[Cells]:
    """Cells under `VARIANT`."""
    for result in variants:
        for number, row in enumerate(result.rows):
            yield (result.variant.name if number == 0 else "", *_row(row))


def scale_rows(scales: Iterable[Scale]) -> Iterator[Cells]:
    """Cells under `SCALES`."""
    for scale in scales:
        yield scale.what, scale.rod, scale.field, scale.why


def full_size_rows(rows: Iterable[FullSizeRow]) -> Iterator[Cells]:
    """Cells under `FULL_SIZE`."""
    for row in rows:
        number = row.number
        yield (
            number.q, number.what, _range(number.low, number.high, number.unit),
            "none" if row.ours is None else _range(*row.ours, number.unit), _yes(row.near),
        )  # fmt: skip


def disorder_rows(rows: Iterable[Disorder]) -> Iterator[Cells]:
    """Cells under `DISORDER`."""
    for row in rows:
        yield f"{row.speed:g} r/min", f"{row.entropy:.3f}", f"{row.lyapunov:+.2f} 1/s", f"{row.per_turn:+.2f}"


def _range(low: float, high: float, unit: str) -> str:
    return f"{low:.3g} {unit}" if low == high else f"{low:.3g} to {high:.3g} {unit}"


def _number(value: float | None, form: str) -> str:
    return "none" if value is None else form.format(value)


def _yes(truth: bool) -> str:
    return "yes" if truth else "no"
