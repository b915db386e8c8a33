# SPDX-License-Identifier: Apache-2.0
"""Report page: one self-contained HTML file that opens without a network."""

import base64
import json
from collections.abc import Mapping
from html import escape
from importlib.resources import files
from itertools import groupby
from pathlib import Path
from typing import Any

from drill_twin.core import __version__
from drill_twin.core.severity import Grade, told
from drill_twin.core.table import Column, Table
from drill_twin.dynamics.discretisation.notes import ON_THE_JOINT
from drill_twin.io.bag.virtual_bags import RecordBag
from drill_twin.io.messages.drawing.geometry import default_exaggeration
from drill_twin.report.charts import plotly_packed, view_data
from drill_twin.report.figures import CAPTIONS, OVER_TIME, left_out
from drill_twin.report.load_text import answers, applied, units_of
from drill_twin.report.recording import Recording
from drill_twin.report.string_curve import FLAT, deviated
from drill_twin.report.text import (
    NOT_VALIDATED,
    column_rows,
    findings,
    interval,
    irregular,
    limitations,
    provenance,
    timeline_rows,
    transient,
)
from drill_twin.report.verdict import verdict, widest
from drill_twin.scene import Scene
from drill_twin.whirl.motion.stick_slip_index import TIME_BASE

_WIDTHS = (
    "The well as it is drilled; hole, string and its motion across the hole are drawn {:g} times as wide as they are. "
    "Orbits are in the hole at their depth, x towards {}."
)
_FLAT = (
    "The assembly over measured depth, by its distance from the axis of the hole, x towards {}; grey: the hole, pale "
    "blue: the pipe. A double click shows the whole string."
)
_HOW = (
    "Charts show values under the pointer and zoom where they are dragged, a double click shows all; a click on a "
    "picture shows it at its full size."
)


def build_page(
    recording: Recording, summary: Mapping[str, Any], figures: Mapping[str, Path], charts: Mapping[str, Any]
) -> str:
    """HTML text of a report.

    Args:
        recording: The run.
        summary: Summary of the recording.
        figures: PNG files by name.
        charts: Figures that are drawn by plotly, by name (`drill_twin.report.charts`).
    """
    scene = recording.scene if recording.scene_known else None
    name, moves = scene.name if scene else recording.path.name, scene is not None and len(recording.poses) > 0
    lead, told = applied({**summary, **(summary.get("surface") or {})}), limitations(summary)
    notes = [line for line in told if line.startswith(ON_THE_JOINT)]
    body = [
        f"<h1>{escape(name)}</h1>",
        f'<p class="lead">{escape(scene.description)}</p>' if scene else "",
        *(f'<p class="verdict">{escape(sentence)}</p>' for sentence in verdict(summary, str(recording.path))),
        *(f'<p class="lead">{escape(line)}</p>' for line in (lead, *(f"Note: {line}" for line in notes))),
        _view(scene) if scene and moves else "",
        _cards(summary) if recording.places else f"<section>{Table((), list(answers(summary))).html()}</section>",
        _warning([*(line for line in told if line not in notes), *_not_drawn(recording)]),
        '<div class="columns"><section>',
        Table((), findings(summary)).html(),
        "</section><section>",
        Table((), provenance(summary)).html(),
        "</section></div>",
        f"<section>{Table((), columns).html()}</section>" if (columns := list(column_rows(summary))) else "",
        f"<h2>Over time</h2><p>{_HOW}</p>",
        '<section class="stack">',
        *(_both(figures[name], name) for name in OVER_TIME if name in figures),
        "</section>",
        _timeline(summary) if recording.places else "",
        "<h2>Orbits, spectrum and shapes</h2>" if figures.keys() & CAPTIONS.keys() else "",
        *(_figure(name, figures) for name in CAPTIONS if name in figures),
        _scene(scene) if scene and not isinstance(recording.bag, RecordBag) else "",
        f"<footer>drawn by drill_twin {escape(__version__)} from {escape(recording.path.name)}</footer>",
    ]  # fmt: skip
    plots = json.dumps(charts, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")
    data = {"chart-data": plots} | ({"view-data": view_data(recording)} if moves else {})
    code = ("zoom.js", "charts.js", *(("view.js",) if moves else ()))
    return html_page(f"{name}: drill_twin report", "".join(body), scripts(data, *map(asset, code)))


def html_page(title: str, body: str, scripts: str = "") -> str:
    """Text of a page in the style of the report.

    Args:
        title: Title of the window.
        body: Elements of the page.
        scripts: Elements `script` after them.
    """
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f'<title>{escape(title)}</title><link rel="icon" href="data:,"><style>{asset("page.css")}</style></head>\n'
        f"<body><main>{body}</main>\n{scripts}</body></html>\n"
    )


def _scene(scene: Scene) -> str:
    """Parts of a run that are not validated, and its scene."""
    return (
        "<h2>What is not validated</h2><section><ul>"
        + "".join(f"<li>{escape(text)}</li>" for text in NOT_VALIDATED)
        + "</ul></section><h2>The scene</h2><section>"
        f"<p>{escape(scene.provenance or 'The scene does not say where its numbers come from.')}</p>"
        f"<details><summary>all of it, as it was run</summary><pre>{escape(scene.to_yaml())}</pre></details></section>"
    )


def _not_drawn(recording: Recording) -> list[str]:
    """A sentence for each reason for which figures are left out; none for the record of a rig, which has one figure."""
    if isinstance(recording.bag, RecordBag):
        return []
    reasons = groupby((lacking := left_out(recording)), lacking.__getitem__)
    return [f"not drawn: {', '.join(names)} (the recording holds {why})".replace("_", " ") for why, names in reasons]


def card(value: float | str | None, form: str, name: str, none: str = "none") -> str:
    """Number in a box with its name."""
    return f"<div><b>{none if value is None else form.format(value)}</b><span>{escape(name)}</span></div>"


def _cards(summary: Mapping[str, Any]) -> str:
    """Five numbers of a run: severity with what decided it, onset and frequency of whirl, radius, stick-slip."""
    units = units_of(summary)
    word, _, decided = told(summary["severity"], units).partition(": ")
    row = summary["severity_by_quantity"].get("stick_slip", {})
    last = min(TIME_BASE, summary["duration_s"])
    index = f"stick-slip index of the bit, last {last:.3g} s" + (f", {Grade(row['grade']).word}" if row else "")
    mark, radius = widest(summary) or ("any mark", None)
    whose = " of a transient" * transient(summary)
    frequency = card(summary["whirl_frequency_hz"], "{:+.2f} Hz", f"whirl{whose}, positive = forward")
    if irregular(summary):
        frequency = card(interval(summary) or None, "{}", "irregular whirl, over windows", "irregular")
    cards = (
        card(f"severity {word}", "{}", f"decided by {decided}" if decided else "no quantity is known"),
        card(summary["onset_s"], "{:.2f} s", f"onset{whose or ' of whirl'}"),
        frequency,
        card(None if radius is None else units.text(radius, "offset"), "{}", f"largest radius, {mark}", "not seen"),
        card(summary["stick_slip_index"], "{:.2f}", index, "unknown"),
    )
    return f'<div class="cards">{"".join(cards)}</div>'


def _warning(lines: list[str]) -> str:
    items = "".join(f"<li>{escape(line)}</li>" for line in lines)
    return f'<section class="warning"><ul>{items}</ul></section>' if lines else ""


def _timeline(summary: Mapping[str, Any]) -> str:
    columns = (
        Column("from", right=True), Column("to", right=True), Column("state", whole=True), Column("what decided it")
    )  # fmt: skip
    table = Table(columns, timeline_rows(summary["motion"])).html(named=False)
    return f'<h2>Motion of the string</h2><section class="timeline">{table}</section>'


def _figure(name: str, figures: Mapping[str, Path]) -> str:
    caption = f"<figcaption>{escape(CAPTIONS[name])}</figcaption>"
    return f"<section><figure>{_both(figures[name], name)}{caption}</figure></section>"


def _both(path: Path, name: str) -> str:
    """Picture, and the place of the chart that takes its place."""
    return (
        f'<div class="both"><div class="chart" data-name="{name}"></div>{picture(path, name.replace("_", " "))}</div>'
    )


def picture(path: Path, name: str) -> str:
    """Element of a PNG file, with its bytes."""
    data = base64.b64encode(path.read_bytes()).decode()
    return f'<div class="picture"><img alt="{escape(name)}" src="data:image/png;base64,{data}"></div>'


def _view(scene: Scene) -> str:
    factor = default_exaggeration(scene.length, scene.hole.radius)
    towards = "the low side" if not scene.hole.survey else "the low side at the top"
    told = _FLAT.format(towards) if scene.length > FLAT else _WIDTHS.format(factor, towards) if deviated(scene) else ""
    return (
        '<h2>The string in motion</h2><section id="view">'
        f"{f'<p>{told}</p>' if told else ''}"
        '<p class="wait">loading the interactive view ...</p>'
        '<p class="no">This browser cannot show the interactive view (it needs WebGL); the figures below show the '
        "same.</p>"
        '<div class="plots"><div id="view-3d"></div><div id="view-2d"></div></div><div class="controls">'
        '<button id="view-play" type="button">Play</button>'
        '<input id="view-time" type="range" min="0" max="1" value="0" aria-label="time">'
        '<output id="view-label"></output>'
        '<label>pace <select id="view-pace"><option value="0.1">1/10</option><option value="0.25">1/4</option>'
        '<option value="1" selected>real time</option><option value="4">4 x</option></select></label>'
        '<label>paths of <select id="view-trail"><option value="0.5">0.5 s</option>'
        '<option value="2" selected>2 s</option><option value="1000000">the run</option></select></label>'
        "</div></section>"
    )


def scripts(data: Mapping[str, str], *code: str) -> str:
    """Elements `script` of a page: JSON texts by their id, plotly, and code that uses both once `plotlyReady` is."""
    named = {**data, "plotly-packed": plotly_packed()}
    return "\n".join(
        (
            *(f'<script type="application/json" id="{name}">{text}</script>' for name, text in named.items()),
            *(f"<script>{text}</script>" for text in (asset("plotly.js"), *code)),
        )
    )


def asset(name: str) -> str:
    """Text of a file beside this module."""
    return files("drill_twin.report").joinpath("assets", name).read_text("utf-8")
