# SPDX-License-Identifier: Apache-2.0
"""Command `drill-twin modes`: damped modes, critical speeds and growth rates of a scene."""

from pathlib import Path
from typing import Annotated

import typer

from drill_twin.cli import options
from drill_twin.cli.emit import emit
from drill_twin.cli.show import shown_progress
from drill_twin.core.files.output import make_folder


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
    from drill_twin.studies.answers import shown_modes

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
    emit(result, shown_modes(table, diagram, own), json=json, folder=out, files={"modes.json": result, **figures})
