# SPDX-License-Identifier: Apache-2.0
"""Commands `drill-twin scene list`, `new`, `check` and `schema`: scene files, also from a well plan."""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from drill_twin.cli import options
from drill_twin.cli.emit import check_new, emit, say, write_file
from drill_twin.cli.show import print_json, remark
from drill_twin.core.errors import ArgumentError, SceneError
from drill_twin.core.table import Table

if TYPE_CHECKING:
    from drill_twin.scene import Scene


def scenes(json: options.JsonOption = False) -> None:
    """List the installed scenes."""
    from drill_twin.scene import load_scene, presets, well_scenes
    from drill_twin.scene.schema import first_sentence, set_points_of

    loaded = {name: (path, load_scene(path)) for name, path in (presets() | well_scenes()).items()}
    data = [{"file": str(path), **_facts(scene), "scene": name} for name, (path, scene) in loaded.items()]
    rows = (
        (
            name,
            scene.unit_system.text(scene.length, "length"),
            *set_points_of(scene),
            f"{scene.rig.duration:g} s",
            first_sentence(scene.description),
        )
        for name, (_, scene) in loaded.items()
    )
    headings = ("scene", "string", "weight on bit", "rotation", "time", "what it is")
    emit(data, [Table(headings, rows, right=(1, 2, 3, 4))], json=json)


def check(
    scene: options.SceneArgument,
    change: options.SetOption = [],  # noqa: B006  typer makes a new list of it
    yaml: Annotated[
        bool, typer.Option("--yaml", help="Print the whole scene with units and defaults, as YAML.")
    ] = False,
    json: options.JsonOption = False,
) -> None:
    """Check a scene file, and print each problem in a line: its place, what was expected, what was found."""
    from drill_twin.dynamics.discretisation.notes import notes_on
    from drill_twin.scene import load_scene, scene_path
    from drill_twin.scene.schema import scene_rows
    from drill_twin.scene.set_points import Schedule

    try:
        described = load_scene(scene, overrides=options.overrides(change))
    except SceneError as error:
        if not error.problems:
            raise
        for problem in error.problems:
            print(f"drill-twin: error: {problem}", file=sys.stderr)
        raise typer.Exit(2) from None
    schedule = Schedule.from_scene(described)
    if json:
        print_json({"file": str(scene_path(scene)), **_facts(described), "notes": notes_on(described)})
    elif yaml:
        print(described.to_yaml(), end="")
    else:
        notes = [("note", note) for note in notes_on(described)]
        say(Table((), [("scene", f"{scene_path(scene)}, without errors"), *scene_rows(described), *notes]))
        if schedule.record is not None:
            print(schedule.record.report)


def schema(
    out: Annotated[Path | None, options.folder_option("Write scene.schema.json to this folder instead.")] = None,
    replace: options.ReplaceOption = False,
) -> None:
    """Print the JSON Schema of scene files, for completion and checks in an editor."""
    from drill_twin.scene.json_schema import schema_text

    if out is None:
        print(schema_text(), end="")
        return
    check_new(out / "scene.schema.json", replace=replace)
    write_file(out / "scene.schema.json", schema_text())


def _facts(scene: Scene) -> dict[str, Any]:
    return {
        "scene": scene.name,
        "description": scene.description,
        "provenance": scene.provenance,
        "length_m": scene.length,
        "hole_radius_m": scene.hole.radius,
        "marks": [mark.name for mark in scene.string.marks],
        "weight_on_bit_n": scene.rig.weight_on_bit.value,
        "rotation_rev_s": scene.rig.rotation.value / math.tau,
        "duration_s": scene.rig.duration,
        "effects": scene.effect_names,
    }


ASKED = {
    "--survey": "CSV file of the survey with measured depth, inclination, azimuth",
    "--tally": "CSV file of the pipe tally from the bit up, with kind, length, od, id, weight, grade, gauge",
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
    bit: Annotated[
        str,
        typer.Option(
            "--bit",
            metavar="DIAMETER TYPE",
            help='Bit, as "8 1/2 in pdc", where the tally lacks size or type: pdc, roller_cone, hybrid, bicentre.',
        ),
    ] = "",
    depth: Annotated[
        str,
        typer.Option(
            "--depth", metavar="LENGTH", help="Measured depth of the bit, if above the last station of the survey."
        ),
    ] = "",
    mud: Annotated[
        str, typer.Option("--mud", metavar="DENSITY", help='Density of the mud, as "1.2 sg" or "10 ppg".')
    ] = "1.2 sg",
    viscosity: Annotated[str, typer.Option("--viscosity", metavar="VISCOSITY", help="Viscosity of the mud.")] = "20 cP",
    friction: Annotated[
        float,
        typer.Option("--friction", metavar="NUMBER", min=0.0, max=5.0, help="Friction coefficient on the wall."),
    ] = 0.25,
    cased_friction: Annotated[
        float | None,
        typer.Option(
            "--cased-friction",
            metavar="NUMBER",
            min=0.0,
            max=5.0,
            help="Friction coefficient in the casing, if another.",
        ),
    ] = None,
    wob: options.WeightOption = "100 kN",
    rpm: options.RpmOption = "120 rpm",
    units: Annotated[
        Literal["", "si", "field"],
        typer.Option(
            "--units",
            metavar="si|field",
            help="Units of tables and figures, and of columns whose heading names none: m, mm, kg/m or ft, in, lb/ft.",
            show_default=False,
        ),
    ] = "",
    replace: options.ReplaceOption = False,
) -> None:
    """Make a scene from a well plan. In a terminal it asks for survey, tally and hole if they are not given."""
    from drill_twin.scene.lines import yaml_text
    from drill_twin.scene.well_plan.plan import WellPlan
    from drill_twin.scene.well_plan.table import read_table
    from drill_twin.scene.well_plan.tally import NAMES, TOOLS, from_top

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
    if unread := (rows := read_table(plan.tally, NAMES, (), units))[0].unread:
        remark(f"{tally}: not used: {', '.join(unread)}")
    if from_top(rows):
        remark(f"{tally}: turned round, as it begins with drill pipe or ends with the bit")
    law = data["effects"]["bit_torque_stribeck"]
    none = f"no type named, its law is sliding {law.get('sliding')}; --bit names one"
    remark(f"bit: {law.get('bit', none)}")
    for told in (told for told in TOOLS.values() if told in scene.provenance):
        remark(told)
    long, sections = scene.unit_system.text(scene.length, "length"), len(scene.string.sections)
    remark(
        f"{out}: {long}, {sections} sections, {len(scene.hole.survey)} stations. "
        f"Next: drill-twin statics {out}; drill-twin run {out}"
    )


def _ask(option: str) -> str:
    try:
        if sys.stdin.isatty():
            return str(typer.prompt(ASKED[option], err=True))
    except typer.Abort:  # Ctrl-D
        print(file=sys.stderr)
    raise ArgumentError(f"expected {option}, found nothing: {ASKED[option]}")
