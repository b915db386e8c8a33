# SPDX-License-Identifier: Apache-2.0
"""Torque, drag and buckling as plain data, as a table over measured depth in SI, and as tracks."""

import math
from collections.abc import Iterable
from operator import attrgetter
from typing import TYPE_CHECKING, Any

import numpy as np

from drill_twin.core.arrays import Array, number_or_none
from drill_twin.core.table import Column, Table
from drill_twin.dynamics.discretisation.discretise import sections_at
from drill_twin.dynamics.torque_drag.analysis import OperationLoads, Statics
from drill_twin.dynamics.torque_drag.soft_string import CHEN, BucklingState
from drill_twin.scene import Scene

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TOUCHES = 1e-3
"""Side force per length, over the largest of its section, from which an element is on the wall; chosen."""


def statics_data(found: Statics) -> dict[str, Any]:
    """Numbers of each operation, SI."""
    loads = [_operation(found.scene, loads) for loads in found.operations]
    return {"scene": found.scene.name, "operations": loads, "notes": dict(found.notes)}


def _operation(scene: Scene, loads: OperationLoads) -> dict[str, Any]:
    sinusoidal, helical = loads.margins
    operation = loads.operation
    return {
        "operation": operation.name,
        "weight_on_bit_n": operation.weight_on_bit,
        "rotation_rad_s": operation.rotation,
        "axial_speed_m_s": operation.axial_speed,
        "hookload_n": loads.hookload,
        "hookload_soft_string_n": number_or_none(loads.soft.hookload),
        "surface_torque_nm": loads.surface_torque,
        "surface_torque_soft_string_nm": number_or_none(loads.soft.surface_torque),
        "bit_torque_nm": loads.bit_torque,
        "neutral_point_m": loads.neutral_point,
        "stretch_m": loads.stretch,
        "twist_rad": loads.twist,
        "sinusoidal_margin": sinusoidal,
        "helical_margin": helical,
        "buckling": loads.worst_state.label,
        "lock_up_weight_on_bit_n": loads.lock_up,
        "largest_stress_pa": float(loads.along.stress.max()),
        "yield_margin": loads.yield_margin,
        "make_up_margin": loads.make_up_margin,
        "bit_build_force_n": number_or_none(loads.contacts[0].build),
        "bit_walk_force_n": number_or_none(loads.contacts[0].walk),
        "bit_tilt_up_deg": number_or_none(math.degrees(loads.contacts[0].lift)),
        "contacts": [
            {
                "name": contact.name, "distance_from_bit_m": contact.distance_from_bit,
                "side_force_n": contact.force, "tilt_deg": math.degrees(contact.tilt),
            }
            for contact in loads.contacts
        ],
        "parts": [
            {"name": name} | dict(zip([key for _, key, _ in PART], values.tolist(), strict=True))
            for name, values in parts_of(scene, loads)
        ],
    }  # fmt: skip


PART = (
    ("from bit", "distance_from_bit_m", "length"), ("tension", "tension_n", "force"), ("torque", "torque_nm", "torque"),
    ("side force", "side_force_n", "force"), ("contact", "contact_share", ""),
    ("moment", "bending_moment_nm", "torque"), ("stress", "stress_pa", "stress"),
)  # fmt: skip
"""Loads of a section: word, key and kind of unit; from the bit to its lower end, tension and torque at its upper end,
side force of the wall on all of it, share of its length on the wall, largest bending moment, largest stress."""


def parts_of(scene: Scene, loads: OperationLoads) -> list[tuple[str, Array]]:
    """Name of each section from the bit up, and its loads as in `PART`, SI."""
    along, number, found = loads.along, sections_at(scene, loads.length - loads.along.depth), list[tuple[str, Array]]()
    for k, section in enumerate(scene.string.sections):
        own = number == k
        length, side = along.length[own], along.side_force[own]
        touching = length[side > TOUCHES * side.max()].sum() / length.sum()
        found.append((section.name or f"section {k + 1}", np.array([
            along.length[number < k].sum(), along.tension[own][-1], along.torque[own][-1], side @ length, touching,
            along.bending_moment[own].max(), along.stress[own].max(),
        ])))  # fmt: skip
    return found


def depth_table(found: Statics) -> Table:
    """Loads along the string in SI, a row an element from the top down, units in the headings."""
    quantities = (
        ("measured depth", "m"), ("tension", "N"), ("soft string tension", "N"), ("torque", "N m"),
        ("soft string torque", "N m"), ("side force", "N/m"), ("bending moment", "N m"),
        ("equivalent stress", "Pa"), ("sinusoidal buckling load", "N"), ("helical buckling load", "N"),
    )  # fmt: skip
    rows = []
    for loads in found.operations:
        along, soft = loads.along, loads.soft
        values = np.column_stack([
            along.depth, along.tension, 0.5 * (soft.tension[1:] + soft.tension[:-1]), along.torque,
            0.5 * (soft.torque[1:] + soft.torque[:-1]), along.side_force, along.bending_moment, along.stress,
            loads.buckling.sinusoidal, loads.buckling.helical,
        ])  # fmt: skip
        parts = [
            found.scene.string.sections[k].name for k in sections_at(found.scene, loads.length - along.depth).tolist()
        ]
        for row, state, part in zip(values[::-1], loads.states[::-1], parts[::-1], strict=True):
            state_of = BucklingState(int(state)).label
            rows.append([loads.operation.name, *(f"{value:.6g}" for value in row), state_of, part])
    columns = [Column("operation"), *(Column(*heading) for heading in quantities), Column("buckling"), Column("part")]
    return Table(columns, rows)


def tracks(found: Statics) -> "Figure":
    """Figure of all operations; the soft string is dashed."""
    from matplotlib.ticker import MaxNLocator  # takes 0.4 s, which tables do not need

    from drill_twin.report.figures.style import BLUE, GREEN, GREY, ORANGE, PURPLE, VERMILION, blank, styled

    units = found.scene.unit_system
    with styled():
        figure = blank(7.2, f"{found.scene.name}: torque and drag")
        panels = [figure.add_axes((0.08 + 0.235 * k, 0.08, 0.195, 0.75)) for k in range(4)]
        tension, torque, side, buckling = panels
        widths = np.linspace(3.4, 1.0, len(found.operations))  # equal loads lie over each other, the wider ones show
        colours = (BLUE, VERMILION, GREEN, PURPLE, ORANGE) * 9
        for colour, width, loads in zip(colours, widths.tolist(), found.operations, strict=False):
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
        loads_of = [units.show(1.0, "force_per_length") * loads.along.side_force for loads in found.operations]
        most, usual = np.max(loads_of), 1.7 * np.quantile(loads_of, 0.985)
        side.set_xlim(left=0.0, right=usual if usual < most else None)
        if usual < most:  # single contacts at the bit would flatten all else
            side.annotate(
                f"up to {most:.0f}", (0.98, 0.02), xycoords="axes fraction", color=GREY, fontsize=8.5, ha="right"
            )
        buckling.set_xlim(left=0.0, right=max(1.6, buckling.get_xlim()[1]))
        tension.set_ylabel(f"measured depth [{units.length}]")
        figure.legend(*tension.get_legend_handles_labels(), loc="upper left", bbox_to_anchor=(0.07, 0.935), ncols=5)
        figure.text(0.975, 0.905, "dashed: soft string", ha="right", color=GREY, fontsize=9)
    return figure


_NOTHING = 1e-4
"""Share of the largest number of a column below which it is the residual of a balance."""
_ROUNDING = 1e-9
"""Number up to which a column has rounding only, in units of the table; chosen: balances leave torques of 1e-16."""
_COLUMNS = (
    *(("hookload", "force"), ("soft.hookload", "force"), ("surface_torque", "torque")),
    *(("soft.surface_torque", "torque"), ("neutral_point", "length"), ("stretch", "length")),
)
"""Quantities of an operation in the first table, and their kinds of units."""


def _set_point(found: Statics) -> str:
    """Weight and speed of slide and drill; of a scene that gives the weight at the top, that at the bit too."""
    units = found.scene.unit_system
    rig, last = found.scene.rig, found.operations[-1].operation
    text = f"slide and drill with {units.set_point(rig.weight_on_bit.value, rig.rotation.value)}"
    if rig.weight_on_bit.at != "top" or not last.is_on_bottom:
        return text
    return f"{text}, at the top: {units.text(last.weight_on_bit, 'force')} at the bit"


def loads_table(found: Statics) -> Table:
    """Hookload, torque and stretch of each operation, for people."""
    operations, u = found.operations, found.scene.unit_system

    def column(values: Iterable[float], quantity: str = "") -> list[str]:
        shown = [u.show(value, quantity) if quantity else value for value in values]
        nothing = max(_NOTHING * float(np.fmax.reduce(np.abs(shown), initial=0.0)), _ROUNDING)
        return ["locked" if math.isnan(value) else f"{0.0 if abs(value) <= nothing else value:.4g}" for value in shown]

    return Table(
        ("operation", "hookload", "soft", "torque", "soft", "neutral", "stretch", "turns"),
        zip(
            [loads.operation.name for loads in operations],
            *(column(map(attrgetter(name), operations), quantity) for name, quantity in _COLUMNS),
            column(loads.twist / math.tau for loads in operations), strict=True,
        ),
        title=f"{found.scene.name}: {_set_point(found)}; in {u.force}, {u.torque}, {u.length}; neutral point from "
        "the bit; soft: string without bending stiffness"
        + "; locked: friction holds the string" * any(math.isnan(loads.soft.hookload) for loads in operations),
        right=range(1, 8),
    )  # fmt: skip
