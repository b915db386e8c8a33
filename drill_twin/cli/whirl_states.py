# SPDX-License-Identifier: Apache-2.0
"""Command `drill-twin whirl-states`: steady whirl of a scene and its stability."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drill_twin.cli.modes import TurnOption, WeightOption, WithoutOption
from drill_twin.cli.options import JsonOption, SceneArgument, SetOption, overrides

if TYPE_CHECKING:
    from rich.table import Table

    from drill_twin.rotordynamics.whirl_states import WhirlState


def whirl_states(
    scene: SceneArgument,
    wob: WeightOption = "",
    rps: TurnOption = "",
    change: SetOption = [],  # noqa: B006  typer makes a new list of it
    without: WithoutOption = [],  # noqa: B006
    starts: Annotated[
        int,
        typer.Option("--starts", metavar="N", min=0, max=100, help="Random first shapes, besides four modes."),
    ] = 2,
    out: Annotated[
        Path | None, typer.Option("--out", metavar="DIR", help="Write states.json and states.png to this folder.")
    ] = None,
    json: JsonOption = False,
) -> None:
    """Steady whirls that can exist at the final set-points: frequency, ratio to the rotation, stability.

    In the frame that turns with it a steady whirl is an equilibrium, found by Newton's method from several shapes and
    whirl speeds. States are those of the string without bow and eccentricity. Scenes without `stretch` and `torsion`
    take seconds, others minutes.
    """
    from drill_twin.api import rotordynamics
    from drill_twin.cli.show import err, print_json
    from drill_twin.cli.show import out as stdout
    from drill_twin.studies.rotordynamics.data import state_data
    from drill_twin.studies.rotordynamics.whirl_figures import states_figure

    own = rotordynamics.steady_scene(scene, overrides(change, wob=wob, rps=rps), without)
    with err().status("searching"):
        found = rotordynamics.whirl_states(own, random_starts=starts)
    if json:
        print_json([state_data(state) for state in found])
    elif found:
        stdout().print(_table(found, own.name))
    else:
        stdout().print(
            f"{own.name}: no steady whirl found at these set-points; more first shapes with --starts, or a run in time",
            markup=False, soft_wrap=True,
        )  # fmt: skip
    if out is not None:
        from drill_twin.cli.folder import make_folder, write_file
        from drill_twin.report.figures.style import save
        from drill_twin.studies.json_io import json_text

        make_folder(out)
        write_file(out / "states.json", json_text([state_data(state) for state in found]))
        if found:
            save(states_figure(found, own), out / "states.png")
        err().print(f"{out}: states.json{', states.png' if found else ''}", markup=False, soft_wrap=True)


def _table(states: Sequence[WhirlState], name: str) -> Table:
    import math

    from drill_twin.cli.show import grid

    command = states[0].whirl.command
    rows = [
        (
            state.kind, f"{state.frequency:+.4f}", f"{state.ratio:+.4f}", "stable" if state.is_stable else "unstable",
            f"{state.growth:+.3g}", f"{state.growth_frequency:.3g}", f"{state.slip:.3g}",
            f"{100.0 * state.touching:.0f} %",
        )
        for state in states
    ]  # fmt: skip
    title = (
        f"{name}: steady whirl at {command.weight_on_bit:g} N, {command.rotation / math.tau:.4g} rev/s. Frequency in "
        "Hz, ratio to the rotation; fastest disturbance: growth in 1/s, its frequency in the turning frame in Hz; slip "
        "over the speed of the surface; share of the length on the wall."
    )
    columns = ("whirl", "frequency", "ratio", "", "growth", "at", "slip", "on wall")
    return grid(columns, rows, title=title, right=(1, 2, 4, 5, 6, 7))
