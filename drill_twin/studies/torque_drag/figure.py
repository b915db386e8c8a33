# SPDX-License-Identifier: Apache-2.0
"""Tracks over measured depth: tension, torque, side force, compression over the buckling load."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from drill_twin.dynamics.torque_drag.analysis import Statics
from drill_twin.dynamics.torque_drag.buckling import CHEN
from drill_twin.report.figures.style import BLUE, GREEN, GREY, ORANGE, PURPLE, VERMILION, blank, head, styled
from drill_twin.studies.torque_drag.unit_system import UnitSystem

COLOURS = (BLUE, VERMILION, GREEN, PURPLE, ORANGE)


def tracks(found: Statics, units: UnitSystem) -> Figure:
    """Figure of all operations; the soft string is dashed."""
    with styled():
        figure = blank(7.2)
        head(figure, f"{found.scene.name}: torque and drag")
        panels = [figure.add_axes((0.08 + 0.235 * k, 0.08, 0.195, 0.75)) for k in range(4)]
        tension, torque, side, buckling = panels
        widths = np.linspace(3.4, 1.0, len(found.operations))  # equal loads lie over each other, the wider ones show
        for colour, width, loads in zip(COLOURS * 9, widths.tolist(), found.operations, strict=False):
            along, soft, name = loads.along, loads.soft, loads.operation.name
            depth = units.show(1.0, "length") * along.depth
            nodes = units.show(1.0, "length") * (loads.length - np.append(0.0, np.cumsum(along.length)))
            force, couple = units.show(1.0, "force"), units.show(1.0, "torque")
            tension.plot(force * along.tension, depth, color=colour, linewidth=width, label=name)
            tension.plot(force * soft.tension, nodes, color=colour, linestyle="--", linewidth=0.8)
            torque.plot(couple * along.torque, depth, color=colour, linewidth=width)
            torque.plot(couple * soft.torque, nodes, color=colour, linestyle="--", linewidth=0.8)
            side.plot(units.show(1.0, "force_per_length") * along.side_force, depth, color=colour, linewidth=0.8)
            share = np.maximum(-along.tension, 0.0) / loads.buckling.sinusoidal
            buckling.plot(share, depth, color=colour, linewidth=width)
        for limit, label in ((1.0, "sinusoidal"), (float(CHEN), "helical")):
            buckling.axvline(limit, color=GREY, linewidth=0.9, linestyle=":")
            buckling.annotate(label, (limit, 0.02), xycoords=("data", "axes fraction"), rotation=90, color=GREY,
                              fontsize=8.5, ha="right", va="bottom")  # fmt: skip
        tension.axvline(0.0, color=GREY, linewidth=0.8)
        titles = ("tension", "torque", "side force", "compression / sinusoidal load")
        names = (units.force, units.torque, units.force_per_length, "-")
        bottom = units.show(found.operations[0].length, "length")
        for panel, title, unit in zip(panels, titles, names, strict=True):
            panel.set_title(title, fontsize=10)
            panel.set(xlabel=f"[{unit}]", ylim=(bottom, 0.0))
            panel.xaxis.set_major_locator(MaxNLocator(4))
            panel.tick_params(labelleft=panel is tension)
        side.set_xlim(left=0.0)
        buckling.set_xlim(left=0.0, right=max(1.6, buckling.get_xlim()[1]))
        tension.set_ylabel(f"measured depth [{units.length}]")
        figure.legend(*tension.get_legend_handles_labels(), loc="upper left", bbox_to_anchor=(0.07, 0.935), ncols=5)
        figure.text(0.975, 0.905, "dashed: soft string", ha="right", color=GREY, fontsize=9)
    return figure
