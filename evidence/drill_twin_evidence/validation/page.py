# SPDX-License-Identifier: Apache-2.0
"""Page and figures of the comparisons with records."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from drill_twin.core.table import Table
from drill_twin_evidence.validation.comparison import Validation

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_HEAD = """# Validation

<!-- Written by `drill-twin study validate --page docs/validation.md`; do not edit. -->

The twin beside records of rigs. *Fit*: the numbers of the scene were fitted to this part of the record. *Prediction*:
they were not. The records are not part of the package: `DRILL_TWIN_DATA` or `--data` names their folder, with
`ufrj_rig/` (public repository thiagoritto/drillstring) and `well_b/` (Aarsnes and Shor 2018, Fig. 15).
"""

_BLIND = """## A blind test

A second start-up of Well B, with the bit at 2,235 m, was predicted before its record was opened. The 90 % band of the
torque held 90.1 % of the record, and is wide. Break-off torque, period and range of the downhole speed missed their
aims. `python -m drill_twin_evidence.validation.two_depths` prints the numbers; prediction, figures and what was tried
afterwards are in `evidence/docs/blind_test.md`.

## A rotor kit, not yet opened

A shaft with two discs (public repository M-Nouioua/rk4-rotor-unbalance-estimation) was fitted to three conditions at
1,005 rpm. The vectors of the other conditions there are met within 4.5 % and 2.2 deg (rms), and 86 % lie in the 90 %
bands. The vectors at 1,206 rpm, a run-up and the weights of seven sealed conditions are predicted in
`evidence/predictions/`; their records are not opened. What one speed does not determine is in
`evidence/docs/rotor_kit.md`.
"""


def table(found: Validation) -> Table:
    """Numbers of a record beside those of the twin."""
    rows: list[tuple[str, ...]] = []
    for row in found.comparisons:
        measured = "" if row.measured is None else f"{row.measured:.4g}"
        aim = (f"{row.aim:.0%}", "met" if row.met else "missed") if math.isfinite(row.aim) else ("", "")
        rows.append((row.what, row.kind, measured, f"{row.computed:.4g}", f"{abs(row.difference):.1%}", *aim))
    heads = ("number", "kind", "measured", "computed", "difference", "aim", "")
    return Table(heads, rows, title=f"{found.record} by scene {found.scene}", right=(2, 3, 4, 5))


def to_page(found: Sequence[Validation], name: str) -> str:
    """Markdown; figures are `NAME_RECORD.png` in `figures/` beside it."""
    parts = [_HEAD]
    for one in found:
        picture = f"![{one.record}: measured and computed](figures/{name}_{one.record}.png)"
        parts.append(f"## {one.record}\n\nScene `{one.scene}`. {one.about}\n\n{table(one).markdown()}\n\n{picture}\n")
    return "\n".join([*parts, _BLIND])


CLOSE = 4.0
"""Width of the part of a prediction that is drawn again, wider [s]."""


def figure(found: Validation) -> Figure:
    """Measured and computed channels over time, and where there is a prediction a few seconds of it close up."""
    from drill_twin.report.figures.style import BLUE, VERMILION, laid_out, styled

    with styled():
        first = found.traces[0].time
        near = found.fitted_until + 5.0 if found.fitted_until + 5.0 + CLOSE < first[-1] else None
        rows = len(found.traces) + (near is not None)
        drawn = laid_out(1.0 + 2.4 * rows, f"{found.record}: measured and computed")
        panels = drawn.subplots(rows, sharex=near is None, squeeze=False)[:, 0]
        for axes, trace in zip(panels, (*found.traces, *found.traces[: len(panels) - len(found.traces)]), strict=True):
            axes.plot(trace.time, trace.measured, color=BLUE, label="measured")
            axes.plot(trace.time, trace.computed, color=VERMILION, label="computed", linewidth=1.0)
            axes.axvspan(trace.time[0], found.fitted_until, fc="0.93", ec="0.6", zorder=0, label="fitted")
            axes.set_ylabel(trace.label)
            axes.set_xlim(trace.time[0], trace.time[-1])
        if near is not None:
            panels[-1].set_xlim(near, near + CLOSE)
        panels[0].legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=3)
        panels[-1].set_xlabel("time [s]")
        return drawn
