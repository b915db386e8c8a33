# SPDX-License-Identifier: Apache-2.0
"""Modes, critical speeds and growth rates as plain data and figures."""

import cmath
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from drill_twin.core.table import Table
from drill_twin.dynamics.discretisation.resolution import mesh, resolution_of
from drill_twin.dynamics.rotordynamics.assembly_modes import in_trough
from drill_twin.dynamics.rotordynamics.campbell import Campbell, GrowthMap
from drill_twin.dynamics.rotordynamics.forced_response import BEND, JOINT, OFFSET, ForcedResponse
from drill_twin.dynamics.rotordynamics.modes import LATERAL, Mode, ModeTable

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def modes_data(table: ModeTable) -> dict[str, Any]:
    """Set-points and modes; frequencies in Hz, growth in 1/s."""
    command = table.balance.command
    return {
        "weight_on_bit_n": command.weight_on_bit,
        "rotation_rev_s": command.rotation / math.tau,
        "on_axis": table.on_axis,
        "growing": table.growing,
        "slowest_decay_without_oscillation_per_s": table.creeping,
        "modes": [
            {
                "kind": mode.kind,
                "number": mode.number,
                "frequency_hz": mode.frequency,
                "growth_per_s": mode.growth,
                "damping_ratio": mode.damping_ratio,
                "critical_speed_rev_s": mode.frequency if table.assembly and mode.kind == LATERAL else None,
                "share_in_collars": mode.share if table.assembly and mode.kind == LATERAL else None,
                "cut_change_hz": None if cmath.isnan(mode.cut_change) else mode.cut_change.imag / math.tau,
                "frequency_change_hz": None if cmath.isnan(mode.change) else mode.change.imag / math.tau,
                "growth_change_per_s": None if cmath.isnan(mode.change) else mode.change.real,
                "shape_real": mode.shape.real.tolist(),
                "shape_imaginary": mode.shape.imag.tolist(),
            }
            for mode in table.modes
        ],
    }


def response_data(response: ForcedResponse) -> dict[str, Any]:
    """Amplitudes [m] and side forces [N] by cause, place and speed, shape (p,) each."""
    places = [*response.marks, "largest of the assembly"]
    contacts = [{"from_m": low, "to_m": high, "static_n": float(force)}
                for (low, high), force in zip(response.contacts, response.static, strict=True)]  # fmt: skip
    data: dict[str, Any] = {"rotation_rev_s": (response.speeds / math.tau).tolist(), "contacts": contacts}
    for k, cause in enumerate(("unbalance", "bend")):
        data[cause] = {
            "amplitude_m": {name: response.amplitude[:, k, i].tolist() for i, name in enumerate(places)},
            "side_force_n": response.side_force[:, k].T.tolist(),
        }
    return data | {"offset_m": OFFSET, "bend_m": BEND, "bend_length_m": JOINT}


def campbell_data(diagram: Campbell) -> dict[str, Any]:
    """Frequencies [Hz] and growth [1/s] by speed, then mode; critical speeds [rev/s]."""
    return {
        "weight_on_bit_n": diagram.weight_on_bit,
        "rotation_rev_s": (diagram.speeds / math.tau).tolist(),
        "frequency_hz": (diagram.eigenvalues.imag / math.tau).tolist(),
        "growth_per_s": diagram.eigenvalues.real.tolist(),
        "critical": [{"mode": mode + 1, "rotation_rev_s": speed / math.tau} for mode, speed in diagram.critical],
    }


def growth_data(growth: GrowthMap) -> dict[str, Any]:
    """Growth [1/s] by load, then speed, and the least loads with growth above zero [N]."""
    data: dict[str, Any] = {
        "weight_on_bit_n": growth.weights.tolist(),
        "rotation_rev_s": (growth.speeds / math.tau).tolist(),
        "lateral_growth_per_s": growth.lateral.tolist(),
        "whirl_onset_n": growth.onset(growth.lateral).tolist(),
    }
    if growth.torsional is not None:
        data["torsional_growth_per_s"] = growth.torsional.tolist()
        data["stick_slip_onset_n"] = growth.onset(growth.torsional).tolist()
    return data


def modes_table(table: ModeTable, modes: Sequence[Mode] | None = None, only: str = "") -> Table:
    """Table of modes for people.

    Args:
        table: All modes.
        modes: The modes shown; None: all.
        only: What these modes are, in place of the full title.
    """
    command, part, scene, units = table.balance.command, table.assembly, table.scene, table.scene.unit_system
    rows = []
    for mode in table.modes if modes is None else modes:
        sense = ""
        if mode.kind == "lateral" and table.on_axis and abs(mode.frequency) > 1e-9:
            sense = "forward" if mode.frequency * command.rotation >= 0.0 else "backward"
        shown = [f"{mode.kind} {mode.number}", sense, f"{abs(mode.frequency):.4g}"]
        shown += [_change(mode.change.imag / math.tau), f"{mode.growth:+.4g}", _change(mode.change.real)]
        if part is not None:
            at = part.equations.model.rod.arc[abs(mode.shape).argmax()]
            lateral = (
                mode.plane, units.number(mode.eigenvalue.imag, "rotation"), units.number(at, "length", ".0f"),
                f"{100.0 * mode.share:.0f}",
            )  # fmt: skip
            shown = [shown[0], *(lateral if mode.kind == "lateral" else [""] * 4), *shown[2:4], f"{mode.growth:+.2g}"]
        rows.append((*shown, f"{mode.damping_ratio:.2g}"))
    off = "in balance" if scene.effects.wall is None else "on the wall"
    place = "on the axis" if table.on_axis else off
    title = (
        f"{scene.name}: {units.set_point(command.weight_on_bit, command.rotation)}, string {place}. "
        "Frequency in Hz, growth in 1/s (- decays, + grows), +- change between two meshes, one twice as fine as the "
        "other, or rounding where it is more, damping ratio."
    )
    if part is None:
        return Table(("mode", "whirl", "frequency", "+-", "growth", "+-", "damping"), rows, title=title,
                     right=(2, 3, 4, 5, 6))  # fmt: skip
    title += (
        f" Lateral modes belong to the assembly: critical speed, place of the largest motion in {units.length} from "
        "the bit, share of the kinetic energy in the collars in %."
    )
    columns = ("mode", "plane", units.rotation, "at", "%", "Hz", "+-", "growth", "damping")
    return Table(columns, rows, title=f"{scene.name}: {only}" if only else title, right=range(2, 9))


def _change(value: float) -> str:
    return "?" if math.isnan(value) else min(f"{abs(value):.1g}", f"{abs(value):.0e}", key=len)


def campbell_table(diagram: Campbell) -> Table:
    """Speeds and critical speeds for people."""
    scene, units, turns = diagram.scene, diagram.scene.unit_system, diagram.speeds
    rows = (("speeds", units.span(turns.min(), turns.max(), "rotation")), ("critical speeds", critical_text(diagram)))
    return Table((), rows, title=f"{scene.name}: lateral modes at {units.text(diagram.weight_on_bit, 'force')}")


def critical_text(diagram: Campbell) -> str:
    """Critical speeds of a Campbell diagram in words."""
    named = (f"{diagram.scene.unit_system.text(speed, 'rotation')} (mode {k + 1})" for k, speed in diagram.critical)
    return ", ".join(named) or "none up to the largest speed"


SHAPES = 6
"""Largest number of mode shapes in a figure, so that each panel can be read."""
FLOOR, CEILING = 1e-6, 10.0
"""Least bottom of the axes of the forced response over their top; largest top of the axis of amplitudes over the
largest clearance, as the wall limits what lies above; chosen."""
CONTACTS = 4
"""Number of contacts drawn, from the bit up, so that their lines can be told apart."""
PLACES = 200
"""Number of places of the assembly at which its largest clearance is sought; not measured."""


def shapes_figure(table: ModeTable) -> "Figure":
    """Lateral mode shapes along the string, swings in the trough last: component along the largest point and across."""
    from drill_twin.report.figures.style import BLUE, VERMILION, laid_out, styled  # matplotlib takes 0.4 s

    trough = [mode.number for mode in table.of(LATERAL) if in_trough(table, mode)]
    lateral = sorted(table.of(LATERAL), key=lambda mode: mode.number in trough)[:SHAPES]
    command, scene, sign = table.balance.command, table.scene, "+" if table.on_axis else ""
    units = scene.unit_system
    arc = table.assembly.equations.model.rod.arc if table.assembly else mesh(scene, resolution_of(scene)[0]).arc
    end = table.assembly.extent.cut if table.assembly else arc[-1]
    with styled():
        at = units.set_point(command.weight_on_bit, command.rotation)
        figure = laid_out(4.2, f"{scene.name}: lateral modes at {at}")
        panels = figure.subplots(1, max(len(lateral), 1), sharey=True, squeeze=False)[0]
        for panel, mode in zip(panels, lateral, strict=False):
            panel.plot(mode.shape.real, units.show(arc, "length"), color=BLUE)
            panel.plot(mode.shape.imag, units.show(arc, "length"), color=VERMILION, linestyle="--")
            name = f"lateral {mode.number}{', trough' * (mode.number in trough)}"
            panel.set_title(f"{name}\n{mode.frequency:{sign}.3g} Hz\n{mode.growth:+.3g} 1/s", fontsize=10)
            panel.set(xlim=(-1.15, 1.15), xlabel="shape [-]")
        panels[0].set(ylabel=f"distance from bit [{units.length}]", ylim=(0.0, units.show(end, "length")))
        if lateral:
            panels[0].legend(
                ["x", "y"] if table.on_axis else ["to the low side", "level"], loc="upper left", fontsize=8
            )
    return figure


def response_figure(response: ForcedResponse, table: ModeTable) -> "Figure":
    """Amplitudes and side forces over the speed for unbalance (left) and bend, critical speeds dotted.

    Amplitudes beyond the clearance are pale, as the response is linear, and the wall would limit them; so are critical
    speeds of the pipe above the collars.
    """
    from drill_twin.report.figures.style import GREY, INK, MARK_COLOURS, VERMILION, laid_out, styled

    command, scene, units = table.balance.command, table.scene, table.scene.unit_system
    turns = units.show(response.speeds, "rotation")
    offset, bend = (units.text(size, "offset", ".2g") for size in (OFFSET, BEND))
    causes = (f"mass centre {offset} off", f"lowest joint bent by {bend} in {units.text(JOINT, 'length')}")
    names = [f"{mark}, {units.text(at, 'length')}" for mark, at in response.marks.items()]
    assembly = scene.length if table.assembly is None else table.assembly.extent.assembly
    gaps = [scene.clearance_at(at) for at in (*response.marks.values(), *np.linspace(0.0, assembly, PLACES))]
    limits = [*gaps[: len(names)], max(gaps)]
    touching = [f"{units.text(low, 'length')} to {units.text(high, 'length')}" for low, high in response.contacts]
    with styled():
        load, whole = units.text(command.weight_on_bit, "force"), "assembly" if table.assembly else "string"
        figure = laid_out(
            6.4 if touching else 4.0,
            f"{scene.name}: forced response at {load}" + "\n" * (2 + len(names) // 4),
        )
        figure.text(
            0.012, 1.0 - 0.36 / figure.get_size_inches()[1], "dotted: critical speeds, red: rotation; linear; pale: "
            f"{'of pipe above the collars, or ' * bool(table.assembly)}beyond the clearance, where the wall limits it",
            va="top", fontsize=9,
        )  # fmt: skip
        panels = figure.subplots(2 if touching else 1, 2, sharex=True, sharey="row", squeeze=False)
        for k, cause in enumerate(causes):
            for i, label in enumerate([*names, f"largest of the {whole}"]):
                colour = INK if i == len(names) else MARK_COLOURS[i % len(MARK_COLOURS)]
                line = "--" if len(MARK_COLOURS) <= i < len(names) else "-"
                within = np.where(response.amplitude[:, k, i] <= limits[i], response.amplitude[:, k, i], np.nan)
                panels[0, k].plot(turns, units.show(response.amplitude[:, k, i], "offset"), color=colour, alpha=0.25)
                panels[0, k].plot(turns, units.show(within, "offset"), line, color=colour, label=label)
            for i, label in enumerate(touching[:CONTACTS]):
                colour = MARK_COLOURS[i % len(MARK_COLOURS)]
                panels[1, k].plot(turns, units.show(response.side_force[:, k, i], "force"), color=colour, label=label)
                panels[1, k].axhline(
                    units.show(response.static[i], "force"), color=colour, linestyle=":", linewidth=1.0
                )
            panels[0, k].set_title(cause)
            panels[-1, k].set_xlabel(f"rotation [{units.rotation}]")
        for panel in panels.ravel():
            panel.set_yscale("log")
            panel.axvline(units.show(abs(command.rotation), "rotation"), color=VERMILION, linewidth=0.9)
            for mode in table.of(LATERAL):
                if 0.0 < mode.eigenvalue.imag < response.speeds[-1]:
                    at, solid = units.show(mode.eigenvalue.imag, "rotation"), 1.0 if mode.of_collars else 0.35
                    panel.axvline(at, color=GREY, linestyle=":", linewidth=0.9, alpha=solid)
        panels[0, 0].set_ylim(top=min(panels[0, 0].get_ylim()[1], CEILING * units.show(max(gaps), "offset")))
        for panel, _ in panels:
            low, high = panel.get_ylim()
            panel.set_ylim(bottom=max(low, FLOOR * high))
        panels[0, 0].set_ylabel(f"amplitude [{units.offset}]")
        figure.legend(*panels[0, 0].get_legend_handles_labels(), loc="upper left", ncol=4, fontsize=8.5,
                      bbox_to_anchor=(0.0, 1.0 - 0.5 / figure.get_size_inches()[1]))  # fmt: skip
        if touching:
            panels[1, 0].set_ylabel(f"side force +- [{units.force}]")
            panels[1, 0].legend(loc="lower left", bbox_to_anchor=(0.0, 0.99), ncol=4, fontsize=8.5).set_in_layout(False)
            panels[1, 1].set_title("dotted: at rest", fontsize=9, loc="right")
    return figure


def campbell_figure(diagram: Campbell) -> "Figure":
    """Frequency and growth of the lateral modes over the speed of rotation; critical speeds marked."""
    from drill_twin.report.figures.style import GREY, INK, MARK_COLOURS, laid_out, styled

    name, units = diagram.scene.name, diagram.scene.unit_system
    turns, hertz = units.show(diagram.speeds, "rotation"), diagram.eigenvalues.imag / math.tau
    with styled():
        figure = laid_out(5.0, f"{name}: Campbell diagram at {units.text(diagram.weight_on_bit, 'force')}")
        left, right = figure.subplots(1, 2)
        for mode in range(hertz.shape[1]):
            colour = MARK_COLOURS[mode % len(MARK_COLOURS)]
            left.plot(turns, hertz[:, mode], color=colour, label=f"mode {mode + 1}")
            right.plot(turns, diagram.eigenvalues[:, mode].real, color=colour)
        left.plot(turns, diagram.speeds / math.tau, color=GREY, linestyle=":", label="1 x rotation")
        for _, speed in diagram.critical:
            left.plot(units.show(speed, "rotation"), speed / math.tau, "o", color=INK, markersize=5)
        right.axhline(0.0, color=INK, linewidth=0.9)
        for panel, label in ((left, "frequency [Hz], forward whirl positive"), (right, "growth [1/s]")):
            panel.set(xlabel=f"rotation [{units.rotation}]", ylabel=label)
        left.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), fontsize=8, ncol=4)
    return figure


def growth_figure(growth: GrowthMap) -> "Figure":
    """Largest growth rate over weight on bit and speed, with its zero line; beside it the growth of torsion."""
    from matplotlib.colors import TwoSlopeNorm

    from drill_twin.report.figures.style import PURPLE, laid_out, styled

    name, units = growth.scene.name, growth.scene.unit_system
    maps = [(growth.lateral, "lateral: onset of whirl")]
    if growth.torsional is not None:
        maps.append((growth.torsional, "torsion: onset of stick-slip"))
    with styled():
        figure = laid_out(4.6, f"{name}: largest growth rate of the string on the axis")
        panels = figure.subplots(1, len(maps), squeeze=False)[0]
        turns, loads = units.show(growth.speeds, "rotation"), units.show(growth.weights, "force")
        for panel, (rates, title) in zip(panels, maps, strict=True):
            size = max(float(np.abs(rates).max()), 1e-9)
            colours = panel.pcolormesh(turns, loads, rates, cmap="RdBu_r", norm=TwoSlopeNorm(0.0, -size, size))
            if rates.min() < 0.0 < rates.max():
                line = panel.contour(turns, loads, rates, levels=[0.0], colors=[PURPLE], linewidths=2.0)
                panel.clabel(line, fmt={0.0: "growth 0"}, fontsize=9)
            panel.grid(visible=False)
            panel.set(title=title, xlabel=f"rotation [{units.rotation}]")
            figure.colorbar(colours, ax=panel, label="growth [1/s]", pad=0.02)
        panels[0].set_ylabel(f"weight on bit [{units.force}]")
    return figure
