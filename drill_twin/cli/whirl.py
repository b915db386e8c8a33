# SPDX-License-Identifier: Apache-2.0
"""Command `drill-twin whirl`: steady whirl of a scene and its stability."""

from pathlib import Path
from typing import Annotated

import typer

from drill_twin.cli import options
from drill_twin.cli.emit import emit
from drill_twin.cli.show import shown_progress


def whirl(
    scene: options.SceneArgument,
    wob: options.WeightOption = "",
    rpm: options.RpmOption = "",
    change: options.SetOption = [],  # noqa: B006  typer makes a new list of it
    without: options.WithoutOption = [],  # noqa: B006
    starts: Annotated[
        int,
        typer.Option(
            "--starts",
            metavar="N",
            min=0,
            max=100,
            help="Number of random shapes, besides four modes, from which the search begins.",
        ),
    ] = 2,
    over: Annotated[
        str,
        typer.Option(
            "--over",
            metavar="KEY=LO..HI",
            help='Follow each state over a range of "wob=5..80 N", "rpm=60..480" or another number of the scene.',
        ),
    ] = "",
    out: Annotated[Path | None, options.folder_option("Write the results and their figures to this folder.")] = None,
    units: options.UnitsOption = "",
    json: options.JsonOption = False,
) -> None:
    """Find the steady whirls that can exist at the final set-points: frequency, ratio to the rotation, stability.

    In the frame that turns with it a steady whirl is an equilibrium, found by Newton's method from several shapes and
    whirl speeds: first without `stretch` and `torsion`, then with them where the scene has them. Each state is computed
    on finer meshes too, which tell how much of its growth is the mesh's. States hold for the string without bow and
    eccentricity, which modulate them.
    """
    from drill_twin.api import rotordynamics
    from drill_twin.studies import whirl_states as studies

    own = rotordynamics.steady_scene(scene, options.overrides(change, wob=wob, rpm=rpm, units=units), without)
    if over:
        ((key, span),) = options.ranges_of("--over", [over]).items()
        with shown_progress("following"):
            along = rotordynamics.branches(own, over=key, span=span, random_starts=starts)
        branches = {"branches": [studies.branch_data(one) for one in along]}
        drawn = {"branches.png": lambda: studies.branches_figure(along, own.name, own.unit_system)} if along else {}
        shown = studies.shown_branches(own, along, key)
        emit(branches, shown, json=json, folder=out, files={"branches.json": branches, **drawn})
        return
    with shown_progress("searching"):
        found = rotordynamics.whirl_states(own, random_starts=starts)
        modulations, locked = rotordynamics.imperfect_states(own, found)
    sizes = [*(one.size for one in modulations), *(None for _ in locked)]
    data = [studies.state_data(state, size) for state, size in zip((*found, *locked), sizes, strict=True)]
    shares = [None if size is None else size / own.least_clearance for size in sizes]
    files = {"states.json": data, **({"states.png": lambda: studies.states_figure(found, own)} if found else {})}
    emit(data, studies.shown_states(own, found, locked, shares), json=json, folder=out, files=files)
