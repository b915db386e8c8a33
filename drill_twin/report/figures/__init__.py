# SPDX-License-Identifier: Apache-2.0
"""Figures of a report: each takes a recording and returns a matplotlib figure.

Figures over time have the same width and margins, so that they share a time axis where they stand below one another.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from drill_twin.report.recording import Recording

OVER_TIME = ("set_points", "displacement", "motion", "spectrum_over_time")
"""Figures that share the time axis, in their order on the page."""

CAPTIONS = {
    "orbits": "Thick: the wall. Dotted: as far as the centre line can go. Blue: the pipe at its size and the dot its "
    "centre, both at the end. Anticlockwise is positive; with positive rotation that is forward whirl. A small "
    "orbit is enlarged, each panel by itself, with the whole hole in the corner.",
    "spectrum": "A pure circular orbit is one line as high as its radius: right of zero when it turns with the string, "
    "left when it turns against it.",
    "well": "Hole and string with their diameters, tool joints and blades included, towards the low side; the section "
    "follows the azimuth. Side force, tension and torque follow from the recorded shape (elastic, one value an "
    "element); orange points are tension and torque as recorded at the ends.",
    "string_shapes": "z = 0 is the top clamp; the bit is at the lower end. Lateral axes are stretched against z. "
    "A string of more than 600 m is drawn flat: its assembly, by the distance from the axis of the hole.",
}
"""Captions of the other figures, in their order on the page."""

FIGURES = (*OVER_TIME, *CAPTIONS)
"""All figures of a report."""
_FILES = {
    **dict.fromkeys(("set_points", "displacement", "motion"), "over_time"),
    "spectrum_over_time": "spectrum",
    "string_shapes": "orbits",
}
"""Module of each drawing function that is not in a module of its own name."""


def draw(name: str, recording: Recording) -> Figure:
    """One of `FIGURES`; matplotlib is imported with it."""
    from drill_twin.report.figures.style import styled

    with styled():
        figure: Figure = getattr(import_module(f"{__name__}.{_FILES.get(name, name)}"), name)(recording)
    return figure


def left_out(recording: Recording) -> dict[str, str]:
    """Figures that the recording cannot fill, each with the reason."""
    rig, marks, shape, scene = "no states of the rig", "no positions of marks", "no poses of the string", "no scene"
    lacks = {
        rig: () if len(recording.rig) else ("set_points",),
        marks: () if recording.places else ("displacement", "motion", "spectrum_over_time", "orbits", "spectrum"),
        shape: () if len(recording.poses) else ("string_shapes", "well"),
        scene: () if recording.scene_known else ("orbits", "string_shapes", "well"),
    }
    return {name: why for why, names in lacks.items() for name in names}
