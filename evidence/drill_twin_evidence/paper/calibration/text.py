# SPDX-License-Identifier: Apache-2.0
"""Result of a calibration as tables and as JSON."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from drill_twin_evidence.paper.calibration.calibrate import Calibration
from drill_twin_evidence.paper.calibration.objective import FITTED, HELD_OUT
from drill_twin_evidence.paper.calibration.parameters import PARAMETERS

FOUND = ("number", "found", "bounds", "why these bounds")
RESIDUALS = ("fitted number", "published", "off at the start, in 20 %", "off now, in 20 %")

Cells = tuple[str, ...]


def found_rows(done: Calibration) -> Iterator[Cells]:
    """Cells under `FOUND`."""
    for u, value in zip(PARAMETERS, done.values, strict=True):
        yield u.name, f"{value:.3g} {u.unit}".rstrip(), f"{u.low:g} ... {u.high:g}", u.reason


def residual_rows(done: Calibration) -> Iterator[Cells]:
    """Cells under `RESIDUALS`."""
    for number in FITTED:
        yield (
            number.name, f"{number.value:g} {number.unit}".strip(),
            f"{done.tried[0].deviations[number.name]:.2f}", f"{done.best.deviations[number.name]:.2f}",
        )  # fmt: skip


def title(done: Calibration) -> str:
    """Result of the calibration in one line."""
    return (
        f"loss {done.tried[0].total:.2f} at the start, {done.best.total:.2f} found in {len(done.tried)} evaluations, "
        f"seed {done.seed}; validated by drill-twin paper on {len(HELD_OUT)} other numbers and the trends"
    )


def to_dict(done: Calibration) -> dict[str, Any]:
    """Plain types for JSON."""
    return {
        "seed": done.seed, "evaluations": len(done.tried), "loss_at_start": done.tried[0].total,
        "loss": done.best.total, "changes": done.changes, "deviations": done.best.deviations,
        "judged": [number.name for number in HELD_OUT], "tried": [loss.deviations for loss in done.tried],
    }  # fmt: skip
