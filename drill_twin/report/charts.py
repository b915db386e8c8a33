# SPDX-License-Identifier: Apache-2.0
"""Figures as data, for charts of the page that adapt to its width, zoom and show values (`charts.js`, plotly).

The interactive view (`view.js`) has its data from the recording: the well, and shapes of the string and paths of the
marks as small integers in base64, in the frame of the hole at their depth; it puts them into the well as it is drilled.

A chart is taken from the matplotlib figure, so that chart and picture cannot differ. Plotly's own converter knows no
filled areas and no meshes.
"""

import base64
import gzip
import json
from functools import cache
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection, QuadMesh
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import ArrayLike, NDArray
from plotly.offline import get_plotlyjs

from drill_twin.core.arrays import Array
from drill_twin.dynamics.discretisation.discretise import contact_radius
from drill_twin.report.figures import OVER_TIME
from drill_twin.report.figures.style import MARK_COLOURS
from drill_twin.report.recording import Recording
from drill_twin.report.string_curve import assembly_top, well_geometry, widest

CHARTS = (*OVER_TIME, "spectrum", "well")
"""Figures whose values are read; orbits and shapes are in the interactive view."""

_POINTS = 4000
"""Most points of a line."""
_OUTLINE = 1500
"""Most points of an area."""
_SHADES = 33
"""Greys of a mesh."""
_DASHES = {"-": "solid", "--": "dash", ":": "dot", "-.": "dashdot"}


def chart(figure: Figure) -> dict[str, Any]:
    """Title and panels of a figure: each has its title, size [inch], and traces and layout for plotly."""
    width, height = figure.get_size_inches()
    panels = [_panel(axes, float(width), float(height)) for axes in figure.axes]
    return {"title": figure.get_suptitle(), "panels": panels}


def _panel(axes: Axes, width: float, height: float) -> dict[str, Any]:
    place, traces, shapes = axes.get_position(), list[dict[str, Any]](), list[dict[str, Any]]()
    for artist in sorted(axes.get_children(), key=lambda artist: artist.get_zorder()):
        if isinstance(artist, Line2D) and artist.get_transform() != axes.transData:
            shapes.append(_across(artist))
        elif trace := _trace(artist, axes):
            traces.append(trace)
    named = set[str]()
    for trace in traces:
        if text := trace.get("text"):  # a state is named once
            name = text.partition(",")[0]
            trace |= {"name": name, "legendgroup": name, "showlegend": name not in named}
            named.add(name)
    x = _axis(axes.get_xlabel(), axes.get_xlim(), axes.get_xscale())
    y = _axis(axes.get_ylabel(), axes.get_ylim(), axes.get_yscale())
    names = [text.get_text() for text in axes.get_yticklabels()]
    if has_names := any(text[0].isalpha() for text in names if text):
        y |= {"tickvals": axes.get_yticks().tolist(), "ticktext": names}
    if equal := axes.get_aspect() == 1.0:
        y["scaleanchor"] = "x"
    over_depth, closest = y["range"][0] > y["range"][1], equal or has_names
    hover = "y unified" if over_depth else "closest" if closest else "x unified"
    hover = "closest" if any(trace["type"] == "heatmap" for trace in traces) else hover
    return {
        "title": axes.get_title(loc="left") or axes.get_title(),
        "width": round(float(place.width) * width, 2),
        "height": round(float(place.height) * height, 2),
        "traces": traces,
        "layout": {"xaxis": x, "yaxis": y, "shapes": shapes, "hovermode": hover},
    }


def _axis(label: str, limits: tuple[float, float], scale: str) -> dict[str, Any]:
    return {
        "title": {"text": label.replace("\n", "<br>"), "standoff": 6}, "type": scale,
        "range": [float(np.log10(x)) if scale == "log" else float(x) for x in limits],
        "gridcolor": "#e6e6e6", "zeroline": False, "automargin": True,
    }  # fmt: skip


def _trace(artist: Any, axes: Axes) -> dict[str, Any] | None:
    """Trace of a line, an area or a mesh; None for what is not in the coordinates of the data."""
    if isinstance(artist, Line2D):
        return _line(artist)
    if isinstance(artist, QuadMesh):
        return _mesh(artist)
    if artist is axes.patch:
        return None
    if isinstance(artist, PolyCollection):
        rows = [path.vertices for path in artist.get_paths()]
        colour = artist.get_facecolor()[0]
        return _area(np.asarray(rows[0]), colour, artist.get_label(), "") if rows else None
    if isinstance(artist, Patch) and artist.get_data_transform().contains_branch(axes.transData):
        row = artist.get_patch_transform().transform(artist.get_path().vertices)
        return _area(np.asarray(row), artist.get_facecolor(), artist.get_label(), artist.get_gid() or "")
    return None


def _look(line: Line2D) -> dict[str, Any]:
    dash = _DASHES.get(str(line.get_linestyle()), "dash")
    return {"color": to_hex(line.get_color()), "width": line.get_linewidth(), "dash": dash}


def _across(line: Line2D) -> dict[str, Any]:
    """Shape of a line across the panel."""
    x, y = (np.asarray(values, float) for values in line.get_data(orig=False))
    upright, look = x.size == 2 and x[0] == x[1], _look(line)
    along, other, at = ("x", "y", float(x[0])) if upright else ("y", "x", float(y[0]))
    label = {"text": line.get_gid() or "", "textangle": 0, "textposition": "end", "font": {"color": look["color"]}}
    ends = {f"{along}0": at, f"{along}1": at, f"{other}ref": "paper", f"{other}0": 0, f"{other}1": 1}
    return {"type": "line", **ends, "line": look, "label": label}


def _line(line: Line2D) -> dict[str, Any]:
    x, y = (np.asarray(values, float) for values in line.get_data(orig=False))
    keep = _kept(y) if x.size > _POINTS else slice(None)
    look, found = _look(line), _scatter(x[keep], y[keep], line.get_label())
    found |= {"opacity": line.get_alpha() or 1.0, "line": look}
    if not found["name"]:
        found["hoverinfo"] = "skip"
    if line.get_linestyle() == "None":
        found |= {"mode": "markers", "marker": {"color": look["color"], "size": 1.0 + float(line.get_markersize())}}
    return found


def _scatter(x: Array, y: Array, label: object) -> dict[str, Any]:
    name = "" if str(label).startswith("_") else str(label)
    places: dict[str, Any] = {"x": _packed(x)}
    step = np.ptp(x) / (x.size - 1) if x.size > 2 and np.isfinite(x).all() else 0.0
    if step and np.abs(x - x[0] - step * np.arange(x.size)).max() <= 1e-6 * np.ptp(x):  # at equal steps
        places = {"x0": float(x[0]), "dx": float(step)}
    return {"type": "scatter", "mode": "lines", **places, "y": _packed(y), "name": name, "showlegend": name != ""}


def _kept(values: Array) -> NDArray[np.intp]:
    """Indices of the least and the largest value in each of the intervals that a long line is cut into."""
    size = -(-values.size // (_POINTS // 2))
    rows = np.pad(np.nan_to_num(values), (0, -values.size % size), mode="edge").reshape(-1, size)
    begin = np.arange(len(rows)) * size
    ends = np.stack((begin + rows.argmin(axis=1), begin + rows.argmax(axis=1)), axis=1)
    return np.asarray(np.minimum(np.sort(ends, axis=1).ravel(), values.size - 1))


def _area(outline: Array, colour: ArrayLike, label: object, text: str) -> dict[str, Any]:
    every = -(-len(outline) // _OUTLINE)
    points = np.concatenate((outline[::every], outline[-1:]))
    red, green, blue, alpha = np.asarray(colour, float)
    return _scatter(points[:, 0], points[:, 1], label) | {
        "fill": "toself", "fillcolor": f"rgba({255 * red:.0f},{255 * green:.0f},{255 * blue:.0f},{alpha:.3g})",
        "line": {"width": 0}, "hoverinfo": "text" if text else "skip", "hoveron": "fills", "text": text,
    }  # fmt: skip


def _mesh(mesh: QuadMesh) -> dict[str, Any]:
    """Cells by their edges; `_SHADES` greys, evenly over the logarithm of the value."""
    edges, values = np.asarray(mesh.get_coordinates()), np.asarray(mesh.get_array(), float)
    low, high = (limit or 1.0 for limit in mesh.get_clim())
    share, ratio = np.linspace(0.0, 1.0, _SHADES), high / low
    at = (ratio**share - 1.0) / (ratio - 1.0)  # from 0 to 1 to the last bit, as plotly.js asks for
    greys = [f"rgb({grey},{grey},{grey})" for grey in (255 * (1.0 - share)).round().astype(int).tolist()]
    return {
        "type": "heatmap", "x": _packed(edges[0, :, 0]), "y": _packed(edges[:, 0, 1]),
        "z": _packed(values) | {"shape": f"{values.shape[0]}, {values.shape[1]}"}, "zmin": low, "zmax": high,
        "colorscale": list(zip(at.tolist(), greys, strict=True)), "showscale": False,
        "hovertemplate": "%{x:.2f} s, %{y:.2f} Hz: %{z:.3g}<extra></extra>",
    }  # fmt: skip


def _packed(values: Array) -> dict[str, str]:
    """Numbers as float32 in base64, as plotly.js reads them."""
    return {"dtype": "f4", "bdata": base64.b64encode(values.astype("<f4").tobytes()).decode()}


_POINTS_OF_SHAPE, _SHAPE_POINTS = 160, 36_000
"""Most points of a shape, and of all shapes together."""
_SAMPLES = 30_000
"""Most samples of a mark's path."""
_FULL = 16_000
"""Integer for the largest radius of the hole, or for the string's length."""


def view_data(recording: Recording) -> str:
    """JSON for `view.js`; coordinates are int16 in base64, as shares of the hole's radius and of the length."""
    radius, length = widest(recording.scene), recording.scene.length
    shapes = recording.shapes()
    shapes = shapes[:, np.unique(np.linspace(0, shapes.shape[1] - 1, _POINTS_OF_SHAPE).round().astype(int))]
    times = np.unique(np.linspace(0, len(shapes) - 1, _SHAPE_POINTS // shapes.shape[1]).round().astype(int))
    shapes = shapes[times]
    every = -(-len(recording.marks) // _SAMPLES)
    centre, height = recording.centre_lines()[::every], recording.marks.position[::every, :, 2]
    paths = np.stack((centre.real / radius, centre.imag / radius, height / length), axis=-1)
    onset, well = recording.summary.onset, well_geometry(recording.scene)
    units = recording.units
    names = [name.replace("[m]", f"[{units.length}]").replace("[mm]", f"[{units.offset}]") for name in well["names"]]
    data: dict[str, Any] = {
        "full": _FULL,
        "units": {quantity: [units.show(1.0, quantity), getattr(units, quantity)] for quantity in ("length", "offset")},
        "radius": radius,
        "length": length,
        "top": assembly_top(recording.scene),
        "well": well | {"names": names},
        "pipe": contact_radius(recording.scene, np.clip(length + shapes[-1, :, 2], 0.0, length)).tolist(),
        "shapes": {
            "time": recording.poses.time[times].round(4).tolist(),
            "points": shapes.shape[1],
            "values": _packed_shares(shapes / (radius, radius, length)),
        },
        "paths": {"time": recording.marks.time[::every].round(4).tolist(), "values": _packed_shares(paths)},
        "marks": [place.name for place in recording.places],
        "walls": [recording.scene.hole.radius_at(length - place.distance_from_bit) for place in recording.places],
        "clearance": [place.clearance for place in recording.places],
        "colours": [MARK_COLOURS[mark % len(MARK_COLOURS)] for mark in range(centre.shape[1])],
        "onset": onset.time_s if onset else None,
    }
    return json.dumps(data, allow_nan=False, separators=(",", ":"))


@cache
def plotly_packed() -> str:
    """plotly.js, compressed, in base64: a third of its size; made once, which takes 0.3 s."""
    return base64.b64encode(gzip.compress(get_plotlyjs().encode(), 9, mtime=0)).decode()


def _packed_shares(values: Array) -> str:
    whole = np.clip(np.nan_to_num(values) * _FULL, -32767, 32767).round().astype("<i2")
    return base64.b64encode(whole.tobytes()).decode()
