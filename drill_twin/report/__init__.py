# SPDX-License-Identifier: Apache-2.0
"""Report of a bag: summary as JSON, figures, and a page with both.

>>> files = build_report("out/run/bag_0", "out/run")
>>> json.loads(files.summary.read_text())["onset_s"]
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from drill_twin.core.files.output import write_whole, writing
from drill_twin.core.files.plain_json import json_text
from drill_twin.report.figures import FIGURES, draw, left_out

if TYPE_CHECKING:
    from drill_twin.report.recording import Recording

__all__ = ["ReportFiles", "build_report", "draw"]


@dataclass(frozen=True)
class ReportFiles:
    """Paths of the files of a report."""

    page: Path
    """`report.html`, which is complete without the other files."""
    summary: Path
    """`summary.json`."""
    figures: dict[str, Path]
    """PNG files by name; a figure that the recording cannot fill has none."""
    verdict: list[str]
    """Sentences on top of the page (`drill_twin.report.verdict`)."""
    answers: list[tuple[str, str]]
    """Names and texts of what a recording without marks is good for (`drill_twin.report.load_text.answers`)."""


def build_report(
    bag: Recording | str | Path,
    out_dir: str | Path,
    *,
    progress: Callable[[str], None] = lambda _: None,
) -> ReportFiles:
    """Write `report.html`, `summary.json` and the figures; older files of these names are replaced.

    Args:
        bag: A recording, or the path of a bag.
        out_dir: Folder of the report; created if needed.
        progress: Called with the name of each part before it is made.

    Raises:
        BagError: The bag cannot be analysed, or the folder cannot be written.
    """
    from drill_twin.report.load_text import (
        answers,  # here, as reading bags takes 0.3 s, which figures of modes do not need
    )
    from drill_twin.report.recording import Recording, read_recording
    from drill_twin.report.summary import summarise
    from drill_twin.report.verdict import verdict

    progress("analysis")
    recording = bag if isinstance(bag, Recording) else read_recording(bag)
    summary = summarise(recording)
    folder = Path(out_dir)
    files = ReportFiles(
        folder / "report.html",
        folder / "summary.json",
        {name: folder / f"{name}.png" for name in FIGURES if name not in left_out(recording)},
        verdict(summary, str(recording.path)),
        list(answers(summary)),
    )
    with writing(folder, "the report", "choose another folder"):
        folder.mkdir(parents=True, exist_ok=True)
        write_whole(files.summary, json_text(summary))
        from drill_twin.report.charts import CHARTS, chart
        from drill_twin.report.figures.style import save
        from drill_twin.report.page import build_page

        charts = {}
        for name, path in files.figures.items():
            progress(name)
            save(figure := draw(name, recording), path)
            if name in CHARTS:
                charts[name] = chart(figure)
        progress("page")
        write_whole(files.page, build_page(recording, summary, files.figures, charts))
    return files
