# SPDX-License-Identifier: Apache-2.0
"""Figures of a result: those of the report."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from drill_twin.report.recording import Recording


class Plots:
    """Methods that return matplotlib figures; a notebook shows them, `figure.savefig(file)` writes them."""

    if TYPE_CHECKING:

        @property
        def recording(self) -> Recording:
            """The run as the report reads it."""

    def plot_set_points(self) -> Figure:
        """Weight on bit and rotation over time, commanded and applied."""
        return self._draw("set_points")

    def plot_displacement(self) -> Figure:
        """Displacement of the centre line at the marks over time."""
        return self._draw("displacement")

    def plot_motion(self) -> Figure:
        """Motion states and precession over time."""
        return self._draw("motion")

    def plot_spectrum_over_time(self) -> Figure:
        """Two-sided spectrum of the motion across the hole over time."""
        return self._draw("spectrum_over_time")

    def plot_spectrum(self) -> Figure:
        """Two-sided spectrum of the motion across the hole after the onset."""
        return self._draw("spectrum")

    def plot_orbits(self) -> Figure:
        """Orbits of the centre line at the marks across the hole."""
        return self._draw("orbits")

    def plot_well(self) -> Figure:
        """The string in the well at the end, and tracks over measured depth."""
        return self._draw("well")

    def plot_string_shapes(self) -> Figure:
        """Shapes of the string in the hole, and the paths of the marks."""
        return self._draw("string_shapes")

    def _draw(self, name: str) -> Figure:
        from drill_twin.report.build import draw

        return draw(name, self.recording)
