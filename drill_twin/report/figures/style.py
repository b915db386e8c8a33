# SPDX-License-Identifier: Apache-2.0
"""Style of the figures: palette for colour-blind readers (Okabe and Ito 2008), sizes, the shared time axis.

Figures are drawn without pyplot, which has global state and may need a display.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from drill_twin.core.arrays import Array
from drill_twin.core.files.output import whole_file, writing
from drill_twin.core.units.system import UnitSystem

if TYPE_CHECKING:
    from drill_twin.whirl import MarkInfo, Onset

INK, GREY, LIGHT = "#222222", "#767676", "#d9d9d9"
BLUE, VERMILION, GREEN, PURPLE, SKY, ORANGE, YELLOW = (
    "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#F0E442",
)  # fmt: skip

MARK_COLOURS = (BLUE, ORANGE, GREEN, VERMILION, PURPLE, SKY)
MARK_LINES = ("-", "--", "-", ":", "-", "--")

STATE_COLOURS = {
    "not observable": "#fafafa",
    "at rest": "#eeeeee",
    "rotation about a fixed axis": "#bdbdbd",
    "swinging in a plane": "#b2df8a",
    "synchronous whirl": ORANGE,
    "forward whirl": SKY,
    "rolling along the wall": BLUE,
    "second bending": GREEN,
    "irregular": YELLOW,
    "backward whirl": VERMILION,
    "spiral": PURPLE,
    "creeping along the wall": "#80cdc1",
    "striking the wall": INK,
}
"""By the value of `drill_twin.whirl.MotionState`, whose import takes 0.1 s."""

DPI = 130
WIDTH = 10.0
"""Width of every figure [inch]."""
LEFT, RIGHT = 0.098, 0.975
"""Edges of the time axis, as a share of the width."""

_RC: Any = {
    "font.family": "DejaVu Sans",
    "font.size": 10.5,
    "axes.titlesize": 11.5,
    "axes.titlelocation": "left",
    "axes.labelsize": 10.5,
    "axes.edgecolor": GREY,
    "axes.labelcolor": INK,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "axes.grid": True,
    "grid.color": "#e6e6e6",
    "grid.linewidth": 0.8,
    "xtick.color": GREY,
    "ytick.color": GREY,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "legend.frameon": False,
    "legend.fontsize": 9.5,
    "lines.linewidth": 1.2,
    "figure.dpi": DPI,
}


def styled() -> Any:
    """Context manager that sets the style."""
    return mpl.rc_context(_RC)


class NotebookFigure(Figure):
    """Figure that a notebook shows without pyplot."""

    def _repr_png_(self) -> bytes:
        stream = BytesIO()
        self.savefig(stream, format="png", dpi=DPI, facecolor="white")
        return stream.getvalue()


def blank(height: float, title: str = "") -> Figure:
    """Empty figure of the common width and a height [inch], with its title."""
    figure = NotebookFigure(figsize=(WIDTH, height))
    FigureCanvasAgg(figure)
    head(figure, title)
    return figure


def over_time(
    duration: float, heights: Sequence[float], *, title: str, headed: bool = False
) -> tuple[Figure, list[Axes]]:
    """Figure with panels one below the other, on the time axis of all figures over time.

    Args:
        duration: Time of the last sample [s].
        heights: Heights of the panels [inch].
        title: Title of the figure.
        headed: True if the panels have titles.
    """
    top, bottom, gap = 0.66 if headed else 0.62, 0.52, 0.34
    height = top + bottom + sum(heights) + gap * (len(heights) - 1)
    figure = blank(height, title)
    panels: list[Axes] = []
    place = height - top
    for share in heights:
        place -= share
        rectangle = (LEFT, place / height, RIGHT - LEFT, share / height)
        panels.append(figure.add_axes(rectangle, sharex=panels[0] if panels else None))
        place -= gap
    panels[0].set_xlim(0.0, max(duration, 1e-3))
    for panel in panels[:-1]:
        panel.tick_params(labelbottom=False)
    panels[-1].set_xlabel("time [s]")
    return figure, panels


def unbridged(time: Array, values: Array) -> tuple[Array, Array]:
    """Times and values of a line that is broken where samples are missing for more than `GAP` usual intervals."""
    from drill_twin.report.surface import GAP  # here, as it reads bags, which figures of modes do not need

    known = np.isfinite(values)
    time, values = time[known], values[known]
    steps = np.diff(time)
    wide = np.flatnonzero(steps > GAP * np.median(steps)) + 1 if steps.size else np.zeros(0, np.int64)
    return np.insert(time, wide, time[wide]), np.insert(values, wide, math.nan)


def head(figure: Figure, title: str) -> None:
    """Draw the title of a figure, at its upper left."""
    place = 1.0 - 0.08 / figure.get_size_inches()[1]
    figure.suptitle(title, x=0.012, y=place, ha="left", va="top", fontsize=13, fontweight="bold")


def draw_onset(onset: Onset | None, duration: float, panels: Sequence[Axes]) -> None:
    """Draw the onset of whirl, if there was one, as a line through all panels, labelled at the first."""
    if onset is None:
        return
    name = f"onset {onset.time_s:.2f} s"
    for panel in panels:
        panel.axvline(onset.time_s, color=INK, linewidth=1.1, linestyle=(0, (4, 2)), zorder=3, gid=name)
    late = onset.time_s > 0.8 * duration
    inside = bool(panels[0].get_title(loc="left"))
    note(
        panels[0],
        name,
        (onset.time_s, 1.0),
        where=("data", "axes fraction"),
        shift=(-4 if late else 4, -3 if inside else 3),
        ha="right" if late else "left",
        va="top" if inside else "bottom",
        fontsize=9.5,
        color=INK,
        bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.85, "pad": 1.0} if inside else None,
    )


def laid_out(height: float, title: str) -> Figure:
    """Empty figure with a title; its panels are laid out below it so that no label overlaps another."""
    figure = blank(height, title)
    figure.set_layout_engine("constrained", rect=(0.0, 0.0, 1.0, 1.0 - (0.4 + 0.2 * title.count("\n")) / height))
    return figure


def note(
    panel: Axes, text: str, at: tuple[float, float], *, where: Any, shift: tuple[float, float], **looks: Any
) -> None:
    """Draw a short text at a position in the coordinates `where`, shifted by points."""
    panel.annotate(text, at, xycoords=where, xytext=shift, textcoords="offset points", annotation_clip=False, **looks)


def mark_label(units: UnitSystem, *places: MarkInfo) -> str:
    """Names of marks at one place and their position, as `mark_1, 4.4 m from the bit`."""
    far = units.text(places[0].distance_from_bit, "length")
    return f"{', '.join(place.name for place in places)}, {far} from the bit"


def mark_style(mark: int) -> dict[str, Any]:
    """Colour and line style of a mark, the same in all figures."""
    return {"color": MARK_COLOURS[mark % len(MARK_COLOURS)], "linestyle": MARK_LINES[mark % len(MARK_LINES)]}


def save(figure: Figure, path: Path) -> None:
    """Write a figure as PNG, as a whole or not at all.

    Raises:
        BagError: The file cannot be written.
    """
    with writing(path, "the figure", "choose another place"), styled(), whole_file(path) as stream:
        if (layout := figure.get_layout_engine()) is not None:  # else savefig draws all twice, to lay it out first
            layout.execute(figure)
            figure.set_layout_engine("none")
        figure.savefig(stream, format="png", dpi=DPI, facecolor="white", metadata={"Software": None})
