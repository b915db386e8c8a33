# SPDX-License-Identifier: Apache-2.0
"""Weight on bit, rotation, torque and hookload over time, as far as they are recorded; set-points as commanded."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure

from drill_twin.core.arrays import Array
from drill_twin.report.figures.style import BLUE, GREY, ORANGE, draw_onset, over_time
from drill_twin.report.load_text import KILO
from drill_twin.report.recording import Recording


class _Panel(NamedTuple):
    label: str
    unit: str
    lines: dict[str, Array]
    commanded: Array | None = None


def set_points(recording: Recording) -> Figure:
    """One panel a quantity of the rig that the recording holds."""
    found = list(_panels(recording))
    figure, panels = over_time(recording.duration, [1.35] * len(found), title=_title(found))
    for panel, (label, unit, lines, commanded) in zip(panels, found, strict=True):
        largest = max(float(np.nanmax(np.abs(values), initial=1.0)) for values in lines.values())
        scale, prefix = (1e-3, "k") if unit.startswith("N") and largest > KILO else (1.0, "")
        if commanded is not None:
            panel.plot(
                recording.commands.time, scale * commanded, color=GREY, linewidth=4.5, alpha=0.4, label="commanded"
            )
        for name, values in lines.items():
            colour, line = (ORANGE, "--") if name == "bit" else (BLUE, "-")
            panel.plot(recording.rig.time, scale * values, color=colour, linestyle=line, label=name)
        panel.set_ylabel(f"{label} [{prefix}{unit}]")
        panel.margins(y=0.12)
        if len(panel.get_lines()) > 1:
            panel.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=3, borderaxespad=0.2)
    draw_onset(recording.summary.onset, recording.duration, panels)
    return figure


def _panels(recording: Recording) -> Iterator[_Panel]:
    """Panels with at least one line that has values."""
    rig, commands = recording.rig, recording.commands
    turns = 1.0 / math.tau
    for label, unit, lines, commanded in (
        ("weight on bit", "N", {"applied": rig.bit_force}, commands.weight_on_bit if len(commands) else None),
        ("rotation", "rev/s", {"top drive": turns * rig.top_drive_speed, "bit": turns * rig.bit_speed},
         turns * commands.rotation if len(commands) else None),
        ("torque", "N m", {"top drive": rig.top_drive_torque, "bit": -rig.bit_torque}, None),
        ("hookload", "N", {"hookload": rig.hookload}, None),
    ):  # fmt: skip
        known = {name: values for name, values in lines.items() if np.isfinite(values).any()}
        if known:
            yield _Panel(label, unit, known, commanded)


def _title(found: list[_Panel]) -> str:
    names = [panel.label for panel in found]
    return f"{', '.join(names[:-1])} and {names[-1]}".capitalize() if len(names) > 1 else names[0].capitalize()
