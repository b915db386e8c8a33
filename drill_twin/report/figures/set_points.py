# SPDX-License-Identifier: Apache-2.0
"""Weight on bit and rotation over time, as commanded and as applied."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.figure import Figure

from drill_twin.report.figures.style import BLUE, GREY, ORANGE, draw_onset, over_time
from drill_twin.report.recording import Recording
from drill_twin.report.text import KILO


def set_points(recording: Recording) -> Figure:
    """Two panels: weight on bit, and speeds of top drive and bit."""
    figure, (weight, speed) = over_time(recording, [1.35, 1.35], title="Weight on bit and rotation")
    time, rig = recording.rig.time, recording.rig
    largest = np.max(np.abs(rig.bit_force), initial=1.0)
    scale, unit = (1e-3, "kN") if largest > KILO else (1.0, "N")
    if len(recording.commands):
        commanded, commands = recording.commands.time, recording.commands
        weight.plot(commanded, scale * commands.weight_on_bit, color=GREY, linewidth=4.5, alpha=0.4, label="commanded")
        speed.plot(commanded, commands.rotation / math.tau, color=GREY, linewidth=4.5, alpha=0.4, label="commanded")
    weight.plot(time, scale * rig.bit_force, color=BLUE, label="applied")
    speed.plot(time, rig.top_drive_speed / math.tau, color=BLUE, label="top drive")
    speed.plot(time, rig.bit_speed / math.tau, color=ORANGE, linestyle="--", label="bit")
    weight.set_ylabel(f"weight on bit [{unit}]")
    speed.set_ylabel("rotation [rev/s]")
    for panel in (weight, speed):
        panel.margins(y=0.12)
        panel.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=3, borderaxespad=0.2)
    draw_onset(recording, [weight, speed])
    return figure
