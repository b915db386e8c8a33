# SPDX-License-Identifier: Apache-2.0
"""Command `drill-twin new`: a scene file from a well plan."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Literal

import typer

from drill_twin.cli.options import ReplaceOption

ASKED = {
    "--survey": "Survey, a CSV file with measured depth, inclination, azimuth",
    "--tally": "Pipe tally, a CSV file from the bit up with kind, length, od, id, weight, grade, gauge",
    "--hole": 'Diameter of the open hole, as "8 1/2 in"',
}


def new(
    out: Annotated[Path, typer.Argument(metavar="FILE", help="Scene file to write, as wells/my_well.yaml.")],
    survey: Annotated[str, typer.Option("--survey", metavar="CSV", help=ASKED["--survey"] + ".")] = "",
    tally: Annotated[str, typer.Option("--tally", metavar="CSV", help=ASKED["--tally"] + ".")] = "",
    hole: Annotated[str, typer.Option("--hole", metavar="DIAMETER", help=ASKED["--hole"] + ".")] = "",
    casing: Annotated[
        list[str],
        typer.Option(
            "--casing",
            metavar="ID to SHOE",
            help='Casing by its inner diameter, as "12.415 in to 1500 m"; repeatable, top down.',
        ),
    ] = [],  # noqa: B006  typer makes a new list of it
    bit: Annotated[str, typer.Option("--bit", metavar="DIAMETER", help="Bit, if smaller than the hole.")] = "",
    depth: Annotated[
        str, typer.Option("--depth", metavar="LENGTH", help="Measured depth of the bit, if above the last station.")
    ] = "",
    mud: Annotated[str, typer.Option("--mud", metavar="DENSITY", help='Mud, as "1.2 sg" or "10 ppg".')] = "1.2 sg",
    viscosity: Annotated[str, typer.Option("--viscosity", metavar="VISCOSITY", help="Of the mud.")] = "20 cP",
    friction: Annotated[float, typer.Option("--friction", min=0.0, max=5.0, help="Of the string on the wall.")] = 0.25,
    cased_friction: Annotated[
        float | None, typer.Option("--cased-friction", min=0.0, max=5.0, help="The same, in the casing.")
    ] = None,
    wob: Annotated[str, typer.Option("--wob", metavar="FORCE", help="Weight on bit.")] = "100 kN",
    rpm: Annotated[str, typer.Option("--rpm", metavar="SPEED", help="Rotation, with its unit.")] = "120 rpm",
    units: Annotated[
        Literal["", "si", "field"],
        typer.Option(
            "--units",
            metavar="si|field",
            help="Units of columns whose heading names none: m, mm, kg/m or ft, in, lb/ft.",
            show_default=False,
        ),
    ] = "",
    replace: ReplaceOption = False,
) -> None:
    """Make a scene from a well plan; in a terminal, what is not given is asked for."""
    from drill_twin.cli.folder import check_new, write_file
    from drill_twin.cli.show import remark
    from drill_twin.core.errors import SceneError
    from drill_twin.scene.lines import yaml_text
    from drill_twin.scene.well_plan.plan import WellPlan

    check_new(out, replace=replace)
    given = {"--survey": survey, "--tally": tally, "--hole": hole}
    answers = {option: text or _ask(option) for option, text in given.items()}
    for option in ("--survey", "--tally"):
        if Path(answers[option]).resolve() == out.resolve():
            raise SceneError(f"{out}: expected a scene file to write, found the table of {option}; choose another name")
    plan = WellPlan(
        out.stem, Path(answers["--survey"]), Path(answers["--tally"]), answers["--hole"], tuple(casing), bit, depth,
        mud, viscosity, friction, cased_friction, wob, rpm, units,
    )  # fmt: skip
    scene, data = plan.scene()
    write_file(out, "# SPDX-License-Identifier: Apache-2.0\n" + yaml_text(data))
    remark(
        f"{out}: {scene.length:g} m, {len(scene.string.sections)} sections, {len(scene.hole.survey)} stations. "
        f"Next: drill-twin statics {out}; drill-twin run {out}"
    )


def _ask(option: str) -> str:
    from drill_twin.core.errors import SceneError

    if not sys.stdin.isatty():
        raise SceneError(f"{option}: expected it, found nothing. {ASKED[option]}")
    answer: str = typer.prompt(ASKED[option], err=True)
    return answer
