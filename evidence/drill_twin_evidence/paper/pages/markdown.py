# SPDX-License-Identifier: Apache-2.0
"""Tables of the reproduction as Markdown, as in `docs/paper.md`."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from drill_twin_evidence.paper.pages import text
from drill_twin_evidence.paper.runs.reproduction import Reproduction


def build_markdown(done: Reproduction) -> str:
    """All tables, each under its heading."""
    parts = [text.lead(done)]
    parts += ["### Numbers", _table(text.NUMBERS, text.number_rows(done.rows))]
    parts += ["### Trends", _table(text.TRENDS, text.trend_rows(done.trends))]
    parts += ["### All runs", _table(text.RUNS, text.run_rows(done))]
    if done.variants:
        parts += ["### Other readings of the bench", _table(text.VARIANT, text.variant_rows(done.variants))]
    parts += ["### Rod and field", _table(text.SCALES, text.scale_rows(done.scales))]
    if done.full_size:
        parts += ["### The full-size assembly", _table(text.FULL_SIZE, text.full_size_rows(done.full_size))]
        parts += ["### Disorder at 180 kN", _table(text.DISORDER, text.disorder_rows(done.disorder))]
    return "\n\n".join(parts) + "\n"


def _table(columns: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [columns, ["---"] * len(columns), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)
