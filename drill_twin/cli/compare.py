# SPDX-License-Identifier: Apache-2.0
"""Commands `drill-twin compare` and `rerun`: assemblies or set-points beside each other; a bag computed again."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drill_twin.cli import options
from drill_twin.cli.emit import emit, new_folder
from drill_twin.cli.show import shown_progress
from drill_twin.core.errors import ArgumentError
from drill_twin.core.files.output import check_folder
from drill_twin.core.table import Table

if TYPE_CHECKING:
    from drill_twin.api.compared_quantities import ComparedQuantity
    from drill_twin.api.recorded_run import Rerun
    from drill_twin.core.units.system import UnitSystem


def compare(
    cases: Annotated[
        list[str],
        typer.Argument(
            metavar="CASE",
            help='Scenes, as "bha_full_size" or "bha_full_size,wob=120 kN,hole.radius=6 in", or bags; the first is '
            "compared with the others.",
        ),
    ],
    duration: options.DurationOption = "",
    seeds: Annotated[
        int,
        typer.Option(
            "--repeats",
            metavar="N",
            min=1,
            max=100,
            help="Number of runs of a scene, a push and 1 % of its speed apart.",
        ),
    ] = 3,
    change: options.SetOption = [],  # noqa: B006  typer makes a new list of it
    tolerance: Annotated[
        float,
        typer.Option(
            "--tolerance", metavar="SHARE", min=0.0, max=1.0, help="Share by which numbers must differ to be shown."
        ),
    ] = 0.05,
    everything: Annotated[bool, typer.Option("--all", help="Show the numbers that do not differ, too.")] = False,
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="New folder of the result.")] = Path("out/compare"),
    replace: options.ReplaceOption = False,
    units: options.UnitsOption = "",
    json: options.JsonOption = False,
) -> None:
    """Run two or more cases and show the differences that matter to a bit run, in a table and on a page.

    Loads and margins come from the balance of forces (`statics`), the rest from the second half of each run. The
    output ends with a verdict: what costs bits and joints, over runs of several seeds, and what the runs can show.
    Writes compare.html, compare.json and compare.png.
    """
    from drill_twin.api.compare import finish, page, prepare, settled
    from drill_twin.api.compared_quantities import quantities
    from drill_twin.api.verdict import again, cost_table, costs, verdicts
    from drill_twin.core.units.system import unit_system
    from drill_twin.report.figures.over_time import draw_runs
    from drill_twin.report.figures.style import save

    if len(cases) < 2:
        raise ArgumentError(
            f"expected two cases or more, found {len(cases)}: name a second scene, or the same with changes"
        )
    common = options.overrides(change, duration=duration, units=units)
    prepared, notes = settled([prepare(text, common) for text in cases])
    new_folder(out, replace=replace)
    found = []
    with shown_progress("computing", len(cases) * seeds, unit="runs") as bar:
        for text, what in zip(cases, prepared, strict=True):
            found.append(finish(text, what, lambda time, text=text: bar.show(f"{text}: {time:.1f} s")))  # type: ignore[misc]
            bar.step(text)
        repeated = [
            again(found, prepared, seed, lambda text, seed=seed: bar.step(f"{text}, seed {seed}"))  # type: ignore[misc]
            for seed in range(1, seeds)
        ]
    ranked = costs([found, *repeated], tolerance)
    rows, shown = quantities(found), unit_system(units or found[0].result.recording.units.name)
    notes += [
        f"{case.name}: its motion is irregular; a run that differs in anything shares its statistics, not its path."
        for case in found
        if case.result.summary["lasting_motion"] == "irregular"
    ]
    notes += [
        f"{case.name} turns to the left: {why}."
        for case in found
        if case.loads and case.loads.operation.rotation < 0.0 and (why := case.result.scene.string.backs_off)
    ]
    notes.append("The size of the calm window is not compared: drill-twin map SCENE computes it.")
    said, table = verdicts(ranked, shown, found), cost_table(ranked, shown)
    differing = [row for row in rows if row.differs(tolerance)]
    content = {
        "cases": cases, "tolerance": tolerance, "differing": [row.name for row in differing], "notes": notes,
        "verdict": said, "costs": [cost._asdict() for cost in ranked],
        "quantities": [{**row._asdict(), "differs": row.differs(tolerance)} for row in rows],
    }  # fmt: skip
    picture = draw_runs([(case.name, case.result.recording) for case in found], "Runs over time", units=shown)
    save(picture, out / "compare.png")  # the page holds it
    agree = (
        f"{len(rows) - len(differing)} quantities agree to {100 * tolerance:g} %, or differ by less than matters; "
        "--all shows them"
    )
    emit(
        content, json=json,
        shown=chain(
            _shown(cases, *((rows, notes) if everything else (differing, [agree, *notes])), shown), [table, *said]
        ),
        folder=out,
        files={
            "compare.html": page(cases, rows, tolerance, notes, out / "compare.png", shown, said, table),
            "compare.json": content,
        },
        also=["compare.png"],
    )  # fmt: skip


def _shown(
    cases: Sequence[str], rows: Sequence[ComparedQuantity], notes: Sequence[str], units: UnitSystem
) -> Iterator[Table | str]:
    from drill_twin.api.compare import table

    yield from (f"{chr(ord('A') + number)}: {text}" for number, text in enumerate(cases))
    if rows:
        yield table(len(cases), rows, units)
    yield from notes


def rerun(
    bag: options.RecordedArgument,
    wob: options.WeightOption = "",
    rpm: options.RpmOption = "",
    change: options.SetOption = [],  # noqa: B006  typer makes a new list of it
    out: Annotated[Path | None, options.folder_option("New folder of the result.", "beside the bag: BAG_rerun")] = None,
    scene: options.SceneOption = "",
    namespace: options.NamespaceOption = "",
    replace: options.ReplaceOption = False,
    units: options.UnitsOption = "",
    json: options.JsonOption = False,
) -> None:
    """Run the commands of a bag again, with other numbers if you like, and compare both runs.

    Of a rig's record the set-points are played on the string of --scene; --wob or --rpm takes the place of one.
    Without --set the frames of the bag are computed again: bit for bit if its commands came in lockstep, else with a
    difference, which is printed. Writes the new bag, comparison.png and rerun.json.
    """
    from drill_twin.api.recorded_run import rerun as run_again
    from drill_twin.cli.analyze import default_folder

    changes = options.overrides(change, wob=wob, rpm=rpm)
    folder = out or default_folder(bag).with_name(f"{default_folder(bag).name.removesuffix('_report')}_rerun")
    check_folder(folder, replace=replace)
    with shown_progress("reading the bag", unit="s") as bar:
        both = run_again(
            bag,
            changes | options.overrides([], units=units),
            scene=scene or None,
            namespace=namespace or None,
            progress=lambda now, end: bar.show("computing", now, end),
        )
        bar.show("drawing")
        new_folder(folder, replace=replace)
        both.computed.to_bag(folder / "bag_0")
        figure = both.plot()
    found = content(both, changes)
    emit(
        found, [Table(("", "recorded", "computed again"), both.table()), agreement(both, changes)], json=json,
        folder=folder, files={"comparison.png": figure, "rerun.json": found}, also=["bag_0"],
    )  # fmt: skip


def agreement(both: Rerun, changes: dict[str, str]) -> str:
    """Sentence on how far both runs agree."""
    source = f"{'set-points' if both.of_record else 'commands'} from {both.commands.source}"
    if both.commands.known_from and not both.of_record:
        source += f" (before {both.commands.known_from:.2f} s, which the bag does not hold, the scene's set-points)"
    if both.stopped:
        return f"{source}; the computed run stopped early: {both.stopped}"
    if both.of_record:
        return source
    if both.identical:
        return f"{source}; all {both.same_frames} frames are the same, bit for bit"
    begin = f"; the first {both.same_frames} frames are the same" if both.same_frames else ""
    difference, units = both.largest_difference, both.computed.recording.units
    far = "" if difference != difference else f", the marks differ by {units.text(difference, 'offset')} at most"  # noqa: PLR0124
    because = "" if changes else (
        "; without --set that comes of commands that reached the simulator a frame late, of another version, processor "
        "or checkpoint, or of numbers that the scene of the bag does not have"
    )  # fmt: skip
    return f"{source}{begin}{far}{because}"


def content(both: Rerun, changes: dict[str, str]) -> dict[str, object]:
    """Content of `rerun.json`."""
    return {
        "bag": str(both.recorded.path),
        "set": changes,
        "commands": both.commands.source,
        "commands_known_from_s": both.commands.known_from,
        "identical": both.identical,
        "same_frames": both.same_frames,
        "largest_difference_m": both.largest_difference,
        "stopped": both.stopped or None,
        "recorded": both.recorded.summary,
        "computed": both.computed.summary,
    }
