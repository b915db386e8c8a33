# SPDX-License-Identifier: Apache-2.0
"""Figures of a result: those of the report."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from drill_twin.report.recording import Recording


def _plot(name: str, what: str) -> Callable[[Plots], Figure]:
    """Method that draws the figure of this name (`drill_twin.report.figures`)."""

    def draw_it(plots: Plots) -> Figure:
        from drill_twin.report.build import draw

        return draw(name, plots.recording)

    draw_it.__name__, draw_it.__qualname__, draw_it.__doc__ = f"plot_{name}", f"Plots.plot_{name}", what
    return draw_it


class Plots:
    """Methods that return matplotlib figures; a notebook shows them, `figure.savefig(file)` writes them."""

    if TYPE_CHECKING:

        @property
        def recording(self) -> Recording:
            """The run as the report reads it."""

    plot_set_points = _plot("set_points", "Weight on bit and rotation over time, commanded and applied.")
    plot_displacement = _plot("displacement", "Displacement of the centre line at the marks over time.")
    plot_motion = _plot("motion", "Motion states and precession over time.")
    plot_spectrum_over_time = _plot("spectrum_over_time", "Two-sided spectrum of the motion across the hole over time.")
    plot_spectrum = _plot("spectrum", "Two-sided spectrum of the motion across the hole after the onset.")
    plot_orbits = _plot("orbits", "Orbits of the centre line at the marks across the hole.")
    plot_well = _plot("well", "The string in the well at the end, and tracks over measured depth.")
    plot_string_shapes = _plot("string_shapes", "Shapes of the string in the hole, and the paths of the marks.")
