# SPDX-License-Identifier: Apache-2.0
"""The reproduction as one HTML file that needs no network."""

from __future__ import annotations

import base64
from collections.abc import Iterable, Mapping, Sequence
from html import escape
from importlib.resources import files
from pathlib import Path

from drill_twin import __version__
from drill_twin_evidence.paper.pages.text import (
    DISORDER,
    FULL_SIZE,
    NUMBERS,
    RUNS,
    SCALES,
    TRENDS,
    VARIANT,
    disorder_rows,
    full_size_rows,
    lead,
    number_rows,
    run_rows,
    scale_rows,
    trend_rows,
    variant_rows,
)
from drill_twin_evidence.paper.runs.reproduction import Reproduction

_CAPTIONS = {
    "paper_speed": "Red: published.",
    "paper_load": "Red: published.",
    "paper_displacement": "Red: published. Blue and orange: ours.",
    "paper_paths": "The circle is the wall; a mark on the rod's surface stays within it.",
    "paper_spectra": "Each line is scaled to its highest peak.",
    "paper_motion": "What the analyzer saw. The paper's order: rotation about a fixed axis, forward whirl, rolling "
    "along the wall, second bending, irregular rotation, reverse whirl, spiral.",
    "paper_full_size": "Red: published velocities. Orbits of the centre line at the near-bit mark.",
}


def build_page(done: Reproduction, figures: Mapping[str, Path]) -> str:
    """The HTML text.

    Args:
        done: The reproduction.
        figures: PNG files by name.
    """
    bench = escape(done.scene.to_yaml())
    body = [
        "<h1>The paper, reproduced</h1>",
        f'<p class="lead">{escape(lead(done))}</p>',
        "<h2>Numbers</h2>", _table(NUMBERS, number_rows(done.rows)),
        "<h2>Trends</h2>", _table(TRENDS, trend_rows(done.trends)),
        *(_figure(name, figures) for name in ("paper_speed", "paper_load", "paper_displacement", "paper_paths",
                                              "paper_spectra", "paper_motion")),
        "<h2>All runs</h2>", _table(RUNS, run_rows(done)),
    ]  # fmt: skip
    if done.variants:
        body += ["<h2>Other readings of the bench</h2>", _table(VARIANT, variant_rows(done.variants))]
    body += ["<h2>Rod and field</h2>", _table(SCALES, scale_rows(done.scales))]
    if "paper_full_size" in figures:
        body += [
            "<h2>The full-size assembly</h2>", _table(FULL_SIZE, full_size_rows(done.full_size)),
            "<h2>Disorder at 180 kN</h2>", _table(DISORDER, disorder_rows(done.disorder)),
            _figure("paper_full_size", figures),
        ]  # fmt: skip
    body.append(f"<details><summary>the bench, as it was run</summary><pre>{bench}</pre></details>")
    body.append(f"<footer>made by drill-twin paper, drill_twin {escape(__version__)}</footer>")
    style = files("drill_twin.report.page").joinpath("assets", "page.css").read_text("utf-8")
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f'<title>The paper, reproduced: drill_twin</title><link rel="icon" href="data:,">'
        f"<style>{style}</style></head>\n"
        f"<body><main>{''.join(body)}</main></body></html>\n"
    )


def _table(columns: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    titles = "".join(f"<th>{escape(column)}</th>" for column in columns)
    lines = "".join(f"<tr>{''.join(f'<td>{escape(cell)}</td>' for cell in row)}</tr>" for row in rows)
    return f"<section><table><thead><tr>{titles}</tr></thead><tbody>{lines}</tbody></table></section>"


def _figure(name: str, figures: Mapping[str, Path]) -> str:
    data = base64.b64encode(figures[name].read_bytes()).decode()
    image = f'<img alt="{escape(name.replace("_", " "))}" src="data:image/png;base64,{data}">'
    return f"<section><figure>{image}<figcaption>{escape(_CAPTIONS[name])}</figcaption></figure></section>"
