# SPDX-License-Identifier: Apache-2.0
"""Command `drill-twin modes`: damped modes, critical speeds and growth rates of a scene."""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drill_twin.cli import options
from drill_twin.cli.emit import emit
from drill_twin.cli.show import shown_progress
from drill_twin.core.files.output import make_folder
from drill_twin.core.table import Table

if TYPE_CHECKING:
    from drill_twin.core.units.system import UnitSystem
    from drill_twin.dynamics.rotordynamics.assembly import Assembly
    from drill_twin.dynamics.rotordynamics.campbell import Campbell
    from drill_twin.dynamics.rotordynamics.modes import Mode, ModeTable
    from drill_twin.scene import Scene
    from drill_twin.scene.set_points.command import Command

NEAR_ROTATION = 0.05
"""Distance of a resonance from the rotation, over it, up to which it is marked: as far as critical speeds agree with
other beam elements (2 to 5 %)."""


def modes(
    scene: options.SceneArgument,
    wob: options.WeightOption = "",
    rpm: options.RpmOption = "",
    change: options.SetOption = [],  # noqa: B006  typer makes a new list of it
    without: options.WithoutOption = [],  # noqa: B006
    count: Annotated[
        int, typer.Option("--count", metavar="N", min=1, max=100, help="Number of modes of each kind.")
    ] = 6,
    campbell: Annotated[
        int, typer.Option("--campbell", metavar="N", min=0, max=1000, help="Draw the Campbell diagram over N speeds.")
    ] = 0,
    growth: Annotated[
        int, typer.Option("--growth", metavar="N", min=0, max=500, help="Draw growth rates over N loads and N speeds.")
    ] = 0,
    out: Annotated[Path | None, options.folder_option("Write modes.json and the figures to this folder.")] = None,
    units: options.UnitsOption = "",
    json: options.JsonOption = False,
) -> None:
    """Compute the damped modes of the turning string: frequency, growth, shape, and its critical speeds.

    The modes hold under the final set-points of the scene. The lateral modes of a long string are computed for its
    assembly on the low side of the hole. --out and --json add the response to unbalance and bend over the rotation.
    Campbell diagram and map go up to twice the speed and the load of the scene. Bow and eccentricity excite the modes
    and change none, so both are left out.
    """
    import numpy as np

    from drill_twin.api import rotordynamics
    from drill_twin.studies import modes as studies

    changes = options.overrides(change, wob=wob, rpm=rpm, units=units)
    own = rotordynamics.steady_scene(scene, changes, without)
    if out is not None:  # before the figures are computed
        make_folder(out)
    command = rotordynamics.final_command(own)
    with shown_progress("computing"):
        table = rotordynamics.modes(own, count=count)
        response = rotordynamics.forced_response(own, table) if json or out is not None else None
        fastest, heaviest = rotordynamics.fastest_of(command), 2.0 * (abs(command.weight_on_bit) or 1.0)
        diagram = growth_rates = None
        if campbell:
            speeds = np.linspace(0.0, fastest, campbell + 1)[1:]
            if command.rotation:  # among the speeds, since there the modes have the numbers of the table
                speeds[np.argmin(np.abs(speeds - abs(command.rotation)))] = abs(command.rotation)
            diagram = rotordynamics.campbell(own, speeds=speeds, count=count, numbered_at=abs(command.rotation))
        if growth:
            speeds, loads = np.linspace(0.0, fastest, growth + 1)[1:], np.linspace(0.0, heaviest, growth)
            growth_rates = rotordynamics.growth_map(own, weights=loads, speeds=speeds)
    result, figures = studies.modes_data(table), {"modes.png": lambda: studies.shapes_figure(table)}
    if response is not None:
        result["response"] = studies.response_data(response)
        figures["response.png"] = lambda: studies.response_figure(response, table)
    if diagram is not None:
        result["campbell"] = studies.campbell_data(diagram)
        figures["campbell.png"] = lambda: studies.campbell_figure(diagram)
    if growth_rates is not None:
        result["growth"] = studies.growth_data(growth_rates)
        figures["growth.png"] = lambda: studies.growth_figure(growth_rates)
    emit(result, _shown(table, diagram, own), json=json, folder=out, files={"modes.json": result, **figures})


def _shown(table: ModeTable, diagram: Campbell | None, scene: Scene) -> Iterator[Table | str]:
    from drill_twin.dynamics.discretisation.notes import notes_on_rotors
    from drill_twin.dynamics.rotordynamics.assembly_modes import in_trough
    from drill_twin.studies.modes import critical_text, modes_table

    units, swings = scene.unit_system, [mode for mode in table.modes if in_trough(table, mode)]
    own = [mode for mode in table.modes if not in_trough(table, mode)]
    yield modes_table(table, own)
    if swings:
        yield modes_table(table, swings, "swings of what lies on the wall, in the trough of the hole")
    yield from _sentences(table)
    yield from notes_on_rotors(scene)
    if table.assembly is not None:
        yield from _assembly(table, table.assembly, units)
        if (mud := scene.effects.added_mass) and not mud.confined:
            yield "mud moves as in open fluid; --set added_mass.confined=true (concentric gap) lowers critical speeds"
        yield _resonances(own, scene, table.balance.command)
    if scene.effects.viscous_drag is not None:
        yield (
            "mud: at rest around a string in the middle of the hole. Not in the model: mud that turns with the string, "
            "which can drive forward whirl slower than half the rotation, and the larger added mass near the wall, "
            "which lowers critical speeds"
        )
    if diagram is not None:
        yield f"critical speeds: {critical_text(diagram)}"


def _resonances(modes: Sequence[Mode], scene: Scene, command: Command) -> Table:
    """Rotations at which an excitation some times a revolution meets a mode."""
    rock, turn = getattr(scene.effects, "bit_regenerative", None), abs(command.rotation)
    orders = sorted({1, 3, *([rock.blades] if rock else [])})

    def cell(speed: float) -> str:
        return scene.unit_system.number(speed, "rotation") + "*" * (abs(speed - turn) < NEAR_ROTATION * turn)

    rows = [
        (f"{mode.kind} {mode.number}", f"{abs(mode.frequency):.4g}",
         *(cell(abs(mode.eigenvalue.imag) / order) for order in orders))
        for mode in modes
    ]  # fmt: skip
    blades = f"{rock.blades}: blades of the bit" if rock else "n: rows / n, as the scene names no blades of its bit"
    return Table(
        ("mode", "Hz", *(f"{order} a turn" for order in orders)), rows, right=range(1, 2 + len(orders)),
        title=f"resonances: rotation in {scene.unit_system.rotation} at which an excitation of an order meets a mode "
        f"(1: unbalance, bend; 3: cones of a roller cone bit; {blades}); *: within {NEAR_ROTATION:.0%} of the rotation",
    )  # fmt: skip


def _assembly(table: ModeTable, part: Assembly, units: UnitSystem) -> Iterator[str]:
    """Sentences on the extent of the assembly, its cut, and the critical speeds."""
    from drill_twin.dynamics.rotordynamics.assembly import ABOVE, LEAN, MOVED
    from drill_twin.dynamics.rotordynamics.assembly_modes import critical_ranges

    lateral, rotation = table.of("lateral"), abs(table.balance.command.rotation)
    for trough, what in ((False, "critical speeds"), (True, "critical speeds of swings in the trough")):
        ranges = critical_ranges(table, trough)
        named = ", ".join(
            units.number(first, "rotation")
            + (f" to {units.number(rest[-1], 'rotation')} ({1 + len(rest)} modes)" if rest else "")
            for first, *rest in ranges
        )
        if named and rotation > 0.0:
            away = min((speed / rotation - 1.0 for near in ranges for speed in near), key=abs)
            named += f"; the nearest is {abs(away):.1%} {'above' if away > 0.0 else 'below'} the rotation"
        place = f"the lowest {units.text(part.collars, 'length')}"
        yield f"{what} of {place}, up to twice the rotation, in {units.rotation}: {named or 'none'}"
    if others := [str(mode.number) for mode in lateral if not mode.of_collars]:
        yield f"lateral {', '.join(others)}: not counted, most energy is in the pipe above (near 50 %: in both)"
    moved = max((abs(mode.cut_change) / abs(mode.eigenvalue) for mode in lateral), default=0.0)
    yield (
        f"the pipe is cut {units.text(ABOVE, 'length')} above the assembly; with the cut at "
        f"{units.text(MOVED, 'length')} the modes listed change by at most {moved:.2%}; modes that change by more than "
        "1 % belong to the pipe and are not listed"
    )
    if part.leans:
        yield f"the hole is vertical: the string leans as at {math.degrees(LEAN):g} degree of inclination"


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
        kinds = "torsional and axial " if table.assembly else ""
        yield (
            f"of this large string {kinds}eigenvalues up to {table.reach:.3g} rad/s are computed: faster growth is not "
            "known"
        )
    if any(cmath.isnan(mode.change) for mode in table.modes):
        yield "+- ?: not compared with another mesh"
