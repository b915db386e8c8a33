# SPDX-License-Identifier: Apache-2.0
"""The tables as Markdown, as `docs/paper.md` shows them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from drill_twin.study.paper import words
from drill_twin.study.paper.outcome import Reproduction


def build_markdown(done: Reproduction) -> str:
    """All tables, each under its heading."""
    parts = [words.lead(done)]
    parts += ["### Numbers", _table(words.NUMBERS, words.number_rows(done.rows))]
    parts += ["### Trends", _table(words.TRENDS, words.trend_rows(done.trends))]
    parts += ["### All runs", _table(words.RUNS, words.run_rows(done))]
    if done.variants:
        parts += ["### Other readings of the bench", _table(words.VARIANT, words.variant_rows(done.variants))]
    parts += ["### Rod and field", _table(words.SCALES, words.scale_rows(done.scales))]
    if done.full_size:
        parts += ["### The full-size assembly", _table(words.FULL_SIZE, words.full_size_rows(done.full_size))]
        parts += ["### Disorder at 180 kN", _table(words.DISORDER, words.disorder_rows(done.disorder))]
    return "\n\n".join(parts) + "\n"


def _table(columns: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [columns, ["---"] * len(columns), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)
