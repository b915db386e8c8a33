# SPDX-License-Identifier: Apache-2.0
"""Page of a comparison: one HTML file with the table and the figure."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from html import escape
from importlib.resources import files
from pathlib import Path

from drill_twin.api.compare.quantities import ComparedQuantity
from drill_twin.core.table import Column, Table


def page(
    names: Sequence[str], found: Sequence[ComparedQuantity], tolerance: float, notes: Sequence[str], figure: Path
) -> str:
    """HTML text; rows that differ are first.

    Args:
        names: Of the cases.
        found: Quantities.
        tolerance: Share from which they differ.
        notes: Sentences above the table.
        figure: PNG file.
    """
    ordered = sorted(found, key=lambda of: not of.differs(tolerance))
    differing = sum(of.differs(tolerance) for of in ordered)
    parts = (("What differs", ordered[:differing]), ("What does not", ordered[differing:]))
    tables = "".join(f"<h2>{title}</h2><section>{_table(names, rows)}</section>" for title, rows in parts if rows)
    picture = base64.b64encode(figure.read_bytes()).decode()
    style = files("drill_twin.report").joinpath("assets", "page.css").read_text("utf-8")
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1"><title>drill_twin: comparison</title>'
        f'<link rel="icon" href="data:,"><style>{style}</style></head>\n<body><main>'
        f"<h1>{escape(' and '.join(names))}</h1>"
        f'<p class="lead">Differences of more than {100.0 * tolerance:g} % first; numbers of runs are of their second '
        "half.</p>"
        f"{''.join(f'<p>{escape(note)}</p>' for note in notes)}{tables}"
        '<h2>Over time</h2><section><div class="picture">'
        f'<img alt="the runs over time" src="data:image/png;base64,{picture}"></div>'
        "</section></main></body></html>\n"
    )


def _table(names: Sequence[str], rows: Sequence[ComparedQuantity]) -> str:
    cells = (
        (Column(of.name, of.shown_unit if of.unit else "").title, *(of.text(case) for case in range(len(names))))
        for of in rows
    )
    return Table(("", *names), cells).html()
