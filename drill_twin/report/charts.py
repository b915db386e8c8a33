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
_DASHES = {"-": "solid", "--": "dash", ":": "dot", "-.": "dashdot"}


def chart(figure: Figure) -> dict[str, Any]:
    """Title and panels of a figure; numbers are float32 in base64."""
    width, height = figure.get_size_inches()
    panels = [_panel(axes, float(width), float(height)) for axes in figure.axes]
    return {"title": figure.get_suptitle(), "panels": panels}


def _panel(axes: Axes, width: float, height: float) -> dict[str, Any]:
    place = axes.get_position()
    artists = sorted(axes.get_children(), key=lambda artist: artist.get_zorder())
    found = [_artist(artist, axes) for artist in artists]
    return {
        "title": axes.get_title(loc="left") or axes.get_title(),
        "width": round(float(place.width) * width, 2),
        "height": round(float(place.height) * height, 2),
        "equal": bool(axes.get_aspect() == 1.0),
        "x": _axis(axes.get_xlabel(), axes.get_xlim(), axes.get_xscale(), None),
        "y": _axis(axes.get_ylabel(), axes.get_ylim(), axes.get_yscale(), axes),
        "traces": [trace for trace in found if trace],
    }


def _axis(label: str, limits: tuple[float, float], scale: str, named: Axes | None) -> dict[str, Any]:
    log = scale == "log"
    axis: dict[str, Any] = {"label": label, "range": [float(np.log10(x)) if log else float(x) for x in limits]}
    if log:
        axis["log"] = True
    names = [] if named is None else [text.get_text() for text in named.get_yticklabels()]
    if named is not None and any(text[0].isalpha() for text in names if text):
        axis["names"], axis["ticks"] = names, named.get_yticks().tolist()
    return axis


def _artist(artist: Any, axes: Axes) -> dict[str, Any] | None:
    """Trace of a line, an area or a mesh; None for what is not in the coordinates of the data."""
    if isinstance(artist, Line2D):
        return _line(artist, axes)
    if isinstance(artist, QuadMesh):
        return _mesh(artist)
    if artist is axes.patch:
        return None
    if isinstance(artist, PolyCollection):
        rows = [path.vertices for path in artist.get_paths()]
        colour = artist.get_facecolor()[0]
        return _area(np.asarray(rows[0]), colour, str(artist.get_label()), "") if rows else None
    if isinstance(artist, Patch) and artist.get_data_transform().contains_branch(axes.transData):
        row = artist.get_patch_transform().transform(artist.get_path().vertices)
        return _area(np.asarray(row), artist.get_facecolor(), str(artist.get_label()), artist.get_gid() or "")
    return None


def _line(line: Line2D, axes: Axes) -> dict[str, Any] | None:
    x, y = (np.asarray(values, float) for values in line.get_data(orig=False))
    look = {"colour": to_hex(line.get_color()), "width": line.get_linewidth(), "opacity": line.get_alpha() or 1.0}
    look["dash"] = _DASHES.get(str(line.get_linestyle()), "dash")
    if line.get_transform() != axes.transData:  # across the panel
        upright = bool(x.size == 2 and x[0] == x[1])
        return {
            "kind": "across",
            "at": float((x if upright else y)[0]),
            "upright": upright,
            "name": line.get_gid() or "",
            **look,
        }
    keep = _kept(y) if x.size > _POINTS else slice(None)
    size = {"marker": float(line.get_markersize())} if line.get_linestyle() == "None" else {}
    name = str(line.get_label())
    return {
        "kind": "line",
        "name": "" if name.startswith("_") else name,
        "x": _packed(x[keep]),
        "y": _packed(y[keep]),
        **look,
        **size,
    }


def _kept(values: Array) -> NDArray[np.intp]:
    """Indices of the least and the largest value in each of the intervals that a long line is cut into."""
    size = -(-values.size // (_POINTS // 2))
    rows = np.pad(np.nan_to_num(values), (0, -values.size % size), mode="edge").reshape(-1, size)
    begin = np.arange(len(rows)) * size
    ends = np.stack((begin + rows.argmin(axis=1), begin + rows.argmax(axis=1)), axis=1)
    return np.asarray(np.minimum(np.sort(ends, axis=1).ravel(), values.size - 1))


def _area(outline: Array, colour: ArrayLike, name: str, text: str) -> dict[str, Any]:
    every = -(-len(outline) // _OUTLINE)
    points = np.concatenate((outline[::every], outline[-1:]))
    red, green, blue, alpha = np.asarray(colour, float)
    rgba = f"rgba({255 * red:.0f},{255 * green:.0f},{255 * blue:.0f},{alpha:.3g})"
    return {
        "kind": "area",
        "name": "" if name.startswith("_") else name,
        "text": text,
        "colour": rgba,
        "x": _packed(points[:, 0]),
        "y": _packed(points[:, 1]),
    }


def _mesh(mesh: QuadMesh) -> dict[str, Any]:
    """Edges of the cells, and the logarithms of their values as bytes between `low` and `high`."""
    edges = np.asarray(mesh.get_coordinates())
    low, high = (float(np.log10(limit or 1.0)) for limit in mesh.get_clim())
    share = (np.log10(np.asarray(mesh.get_array(), float)) - low) / (high - low)
    return {
        "kind": "mesh", "x": _packed(edges[0, :, 0]), "y": _packed(edges[:, 0, 1]), "columns": edges.shape[1] - 1,
        "low": low, "high": high, "values": base64.b64encode((255 * np.clip(share, 0.0, 1.0)).astype("u1")).decode(),
    }  # fmt: skip


def _packed(values: Array) -> str | list[float]:
    """Numbers as float32 in base64, or first, step and count of numbers at equal steps."""
    rows = np.asarray(values, float)
    if rows.size > 2 and np.isfinite(rows).all():
        step = float(rows[-1] - rows[0]) / (rows.size - 1)
        even = float(rows[0]) + step * np.arange(rows.size)
        if np.abs(rows - even).max() <= 1e-6 * np.ptp(rows):
            return [float(rows[0]), step, rows.size]
    return base64.b64encode(rows.astype("<f4").tobytes()).decode()


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
