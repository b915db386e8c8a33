# SPDX-License-Identifier: Apache-2.0
"""`drill-twin analyze` and `drill-twin report`: what a bag tells."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drill_twin.cli.options import BagArgument, JsonOption, ReplaceOption, SceneOption
from drill_twin.errors import BagError

if TYPE_CHECKING:
    from drill_twin.report import Recording, ReportFiles


def analyze(
    bag: BagArgument,
    scene: SceneOption = "",
    out: Annotated[
        Path | None, typer.Option("--out", metavar="FILE", help="Write the findings to this new file too, as JSON.")
    ] = None,
    replace: ReplaceOption = False,
    json: JsonOption = False,
) -> None:
    """Find onset, frequencies and motion states of whirl in a bag.

    The analysis is that of the analyzer node; where the bag holds what the node found live, the two are compared byte
    for byte. A bag whose recorder was killed is read as far as it goes.
    """
    from drill_twin.cli.folder import check_new, write_file
    from drill_twin.cli.show import err, print_findings, print_json
    from drill_twin.report.summary import summarise, to_json

    if out is not None:
        check_new(out, replace=replace)
    with err().status("analysing the bag"):
        summary = summarise(_recording(bag, scene))
    if out is not None:
        write_file(out, to_json(summary))
    if json:
        print_json(summary)
    else:
        print_findings(summary)


def report(
    bag: BagArgument,
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="DIR", help="Folder of the report.", show_default="beside bag_0, or BAG_report"),
    ] = None,
    scene: SceneOption = "",
    replace: ReplaceOption = False,
    json: JsonOption = False,
) -> None:
    """Draw the report of a bag: report.html, which opens from the disk without a network, and its figures as PNG."""
    from drill_twin.cli.show import err, print_json

    folder = out or default_folder(bag)
    existing = folder / "report.html"
    if existing.exists() and not replace:
        raise BagError(f"{existing}: expected none yet, found one; choose another folder with --out, or --replace")
    with err().status("analysing the bag"):
        recording = _recording(bag, scene)
    files = draw(recording, folder)
    if json:
        figures = {name: str(path) for name, path in files.figures.items()}
        print_json({"report": str(files.page), "summary": str(files.summary), "figures": figures})
    else:
        print(files.page)


def draw(recording: Recording, folder: Path) -> ReportFiles:
    """Build the report with a spinner that names the part it is at."""
    from drill_twin.cli.show import err
    from drill_twin.report import build_report

    with err().status("drawing") as status:
        return build_report(recording, folder, progress=lambda part: status.update(f"drawing: {part}"))


def default_folder(bag: Path) -> Path:
    """Where a report goes if nobody says so: `out/run/bag_0` -> `out/run`; any other `x` -> `x_report` beside it."""
    from drill_twin.report.locate import bag_in

    found = bag_in(bag).absolute()
    if found.suffix in {".mcap", ".db3"} and found.is_file():
        found = found.parent if found.parent.name == "bag_0" else found.with_suffix("")
    return found.parent if found.name == "bag_0" else found.with_name(f"{found.name}_report")


def _recording(bag: Path, scene: str) -> Recording:
    from drill_twin.report.recording import read_recording
    from drill_twin.scene import load_scene

    return read_recording(bag, load_scene(scene) if scene else None)
