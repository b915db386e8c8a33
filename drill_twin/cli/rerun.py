# SPDX-License-Identifier: Apache-2.0
"""Command `drill-twin rerun`: the commands of a bag, computed again."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from drill_twin.cli import options
from drill_twin.cli.emit import emit, new_folder
from drill_twin.cli.show import shown_progress
from drill_twin.core.files.output import check_folder
from drill_twin.core.table import Table

if TYPE_CHECKING:
    from drill_twin.api.recorded_run import Rerun


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
    if both.of_record:
        stopped = f"; the computed run stopped early: {both.stopped}" if both.stopped else ""
        return f"set-points from {both.commands.source}{stopped}"
    source = f"commands from {both.commands.source}"
    if both.commands.known_from:
        source += f" (before {both.commands.known_from:.2f} s, which the bag does not hold, the scene's set-points)"
    if both.stopped:
        return f"{source}; the computed run stopped early: {both.stopped}"
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
