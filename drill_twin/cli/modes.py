# SPDX-License-Identifier: Apache-2.0
"""Command `drill-twin modes`: damped modes, critical speeds and growth rates of a scene."""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drill_twin.cli.emit import emit
from drill_twin.cli.options import (
    JsonOption,
    RpmOption,
    SceneArgument,
    SetOption,
    TurnOption,
    UnitsOption,
    WeightOption,
    WithoutOption,
    folder_option,
    overrides,
)
from drill_twin.cli.show import shown_progress
from drill_twin.core.files.output import make_folder
from drill_twin.core.table import Table

if TYPE_CHECKING:
    from drill_twin.core.units.system import UnitSystem
    from drill_twin.dynamics.rotordynamics.campbell import Campbell
    from drill_twin.dynamics.rotordynamics.modes import ModeTable
    from drill_twin.scene import Scene


def modes(
    scene: SceneArgument,
    wob: WeightOption = "",
    rps: TurnOption = "",
    rpm: RpmOption = "",
    change: SetOption = [],  # noqa: B006  typer makes a new list of it
    without: WithoutOption = [],  # noqa: B006
    count: Annotated[int, typer.Option("--count", min=1, max=100, help="Modes of each kind.")] = 6,
    campbell: Annotated[
        int, typer.Option("--campbell", metavar="N", min=0, max=1000, help="Campbell diagram over N speeds.")
    ] = 0,
    growth: Annotated[
        int, typer.Option("--map", metavar="N", min=0, max=500, help="Map of growth rates, N loads by N speeds.")
    ] = 0,
    out: Annotated[Path | None, folder_option("Write modes.json and the figures to this folder.")] = None,
    units: UnitsOption = "",
    json: JsonOption = False,
) -> None:
    """Damped modes of the turning string under its final set-points: frequency, growth, shape.

    Campbell diagram and map go up to twice the speed and the load of the scene. Bow and eccentricity are left out: they
    excite, and change no mode.
    """
    import numpy as np

    from drill_twin.api import rotordynamics
    from drill_twin.dynamics.discretisation.resolution import mesh, resolution_of
    from drill_twin.studies.modes import (
        campbell_data,
        campbell_figure,
        growth_data,
        growth_figure,
        modes_data,
        shapes_figure,
    )

    changes = overrides(change, wob=wob, rps=rps, rpm=rpm, units=units)
    own = rotordynamics.steady_scene(scene, changes, without)
    if out is not None:  # before the figures are computed
        make_folder(out)
    command = rotordynamics.final_command(own)
    with shown_progress("computing"):
        table = rotordynamics.modes(own, count=count)
        fastest, heaviest = 2.0 * (abs(command.rotation) or 10.0), 2.0 * (abs(command.weight_on_bit) or 1.0)
        diagram = growth_rates = None
        if campbell:
            speeds = np.linspace(0.0, fastest, campbell + 1)[1:]
            if command.rotation:  # one of the speeds, since there the modes have the numbers of the table
                speeds[np.argmin(np.abs(speeds - abs(command.rotation)))] = abs(command.rotation)
            diagram = rotordynamics.campbell(own, speeds=speeds, count=count, numbered_at=abs(command.rotation))
        if growth:
            speeds, loads = np.linspace(0.0, fastest, growth + 1)[1:], np.linspace(0.0, heaviest, growth)
            growth_rates = rotordynamics.growth_map(own, weights=loads, speeds=speeds)
    result, named = modes_data(table), own.name
    arc = mesh(own, resolution_of(own)[0]).arc
    figures = {"modes.png": lambda: shapes_figure(table, arc, named, own.unit_system)}
    if diagram is not None:
        result["campbell"] = campbell_data(diagram)
        figures["campbell.png"] = lambda: campbell_figure(diagram, named, own.unit_system)
    if growth_rates is not None:
        result["growth"] = growth_data(growth_rates)
        figures["growth.png"] = lambda: growth_figure(growth_rates, named, own.unit_system)
    emit(result, _shown(table, diagram, own), json=json, folder=out, files={"modes.json": result, **figures})


def _shown(table: ModeTable, diagram: Campbell | None, scene: Scene) -> Iterator[Table | str]:
    units = scene.unit_system
    yield _table(table, scene.name, units)
    yield from _sentences(table)
    if diagram is not None:
        named = ", ".join(f"{units.text(speed, 'rotation')} (mode {mode + 1})" for mode, speed in diagram.critical)
        yield f"critical speeds: {named or 'none up to the largest speed'}"


def _table(table: ModeTable, name: str, units: UnitSystem) -> Table:
    command = table.balance.command
    rows = []
    for mode in table.modes:
        sense = ""
        if mode.kind == "lateral" and table.on_axis and abs(mode.frequency) > 1e-9:
            sense = "forward" if mode.frequency * command.rotation >= 0.0 else "backward"
        rows.append((
            f"{mode.kind} {mode.number}", sense, f"{abs(mode.frequency):.4g}", _change(mode.change.imag / math.tau),
            f"{mode.growth:+.4g}", _change(mode.change.real), f"{mode.damping_ratio:.3g}",
        ))  # fmt: skip
    place = "on the axis" if table.on_axis else "on the wall"
    title = (
        f"{name}: {units.set_point(command.weight_on_bit, command.rotation)}, string {place}. "
        "Frequency in Hz, growth in 1/s (above 0: unstable), +- their change on a mesh twice as fine, damping ratio."
    )
    columns = ("mode", "whirl", "frequency", "+-", "growth", "+-", "damping")
    return Table(columns, rows, title=title, right=(2, 3, 4, 5, 6))


def _change(value: float) -> str:
    return "?" if math.isnan(value) else f"{abs(value):.1g}"


def _sentences(table: ModeTable) -> Iterator[str]:
    """Sentences on what the table leaves out, and where it was not compared with a finer mesh."""
    for kind, count in table.growing.items():
        shown = [mode for mode in table.of(kind) if mode.growth > 0.0]
        if count > len(shown):
            yield f"{count} {kind} modes grow; the table has {len(shown)} of them, among them the fastest"
    for kind, decay in table.creeping.items():
        yield (
            f"{kind}: motions that decay without oscillation (0 Hz, damping ratio 1), the slowest at {decay:.4g} 1/s, "
            "are not listed"
        )
    if math.isfinite(table.reach):
        yield (
            f"of this large string eigenvalues up to {table.reach:.3g} rad/s are computed: faster growth is not known"
        )
    if any(cmath.isnan(mode.change) for mode in table.modes):
        yield "+- ?: not compared with a mesh twice as fine, which has too many unknowns or no balance"
