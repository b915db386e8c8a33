# SPDX-License-Identifier: Apache-2.0
"""Command `drill-twin study analyzer-score`: detection study of the analyzer."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from drill_twin.cli.options import JsonOption, ReplaceOption, WorkersOption, folder_option, time_option


def analyzer_score(
    quick: Annotated[bool, typer.Option("--quick", help="Score a tenth of the records only.")] = False,
    out: Annotated[
        Path | None, folder_option("Write the tables, the numbers and the curves to this folder too.")
    ] = None,
    downhole: Annotated[
        bool,
        typer.Option("--downhole", help="Score what one downhole sub tells of whirl instead (docs/sensors.md)."),
    ] = False,
    noise: Annotated[
        float, time_option("--duration", "With --downhole: length of the noise without whirl", 0.0, 3.6e6)
    ] = 24.0 * 3600.0,
    workers: WorkersOption = 0,
    replace: ReplaceOption = False,
    json: JsonOption = False,
) -> None:
    """Measure the analyzer, beside a plain detector, on frozen records: onset, false alarms, delay and motion states.

    Prints the tables of evidence/docs/detection.md; all of it takes a quarter of an hour on two processors.
    """
    from drill_twin.cli.emit import check_new, emit
    from drill_twin.cli.show import shown_progress
    from drill_twin_evidence.detection.figure import curves_figure
    from drill_twin_evidence.detection.measure import QUICK, Plan, markdown, measure

    if downhole:
        from drill_twin_evidence.detection import downhole as one_sub
        from drill_twin_evidence.detection.cases import BENCH

        sizes = (4, 4, 1) if quick else (len(BENCH), 36, 5)
        found = one_sub.measure_sub(*sizes, noise / 3600.0)
        emit(found, (one_sub.markdown(found).rstrip(),), json=json)
        return
    names = ("analyzer_score.md", "analyzer_score.json", "detection_curves.png")
    if out is not None:
        for name in names:
            check_new(out / name, replace=replace)
    with shown_progress("measuring") as bar:
        result = measure(QUICK if quick else Plan(), workers=workers, progress=bar.show)
    plain = result.to_dict()
    text = markdown(result)
    files = dict(zip(names, (text, plain, lambda: curves_figure(result.curves)), strict=True))
    emit(plain, (text.rstrip(),), json=json, folder=out, files=files)
