# SPDX-License-Identifier: Apache-2.0
"""Result of a calibration as tables and as JSON."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from drill_twin_evidence.paper.calibration.calibrate import Calibration
from drill_twin_evidence.paper.calibration.objective import FITTED, HELD_OUT
from drill_twin_evidence.paper.calibration.parameters import PARAMETERS

FOUND = ("number", "found", "as good from ... to", "bounds", "loss without it", "needed for")
RESIDUALS = ("fitted number", "published", "off at the start, in 20 %", "off now, in 20 %")
BOUNDS = ("number", "why these bounds")

Cells = tuple[str, ...]


def found_rows(done: Calibration) -> Iterator[Cells]:
    """Cells under `FOUND`."""
    for found in done.found:
        u = found.parameter
        unit = f" {u.unit}" if u.unit else ""
        yield (
            u.name, f"{found.value:.3g}{unit}", f"{found.low:.3g} ... {found.high:.3g}", f"{u.low:g} ... {u.high:g}",
            "-" if found.without is None else f"{found.without:+.2f}", "; ".join(found.needed_for),
        )  # fmt: skip


def residual_rows(done: Calibration) -> Iterator[Cells]:
    """Cells under `RESIDUALS`."""
    for number in FITTED:
        yield (
            number.name, f"{number.value:g} {number.unit}".strip(),
            f"{done.start.deviations[number.name]:.2f}", f"{done.best.deviations[number.name]:.2f}",
        )  # fmt: skip


def bound_rows() -> Iterator[Cells]:
    """Cells under `BOUNDS`."""
    for parameter in PARAMETERS:
        yield parameter.name, parameter.reason


def title(done: Calibration) -> str:
    """Result of the calibration in one line."""
    return (
        f"loss {done.start.total:.2f} at the start, {done.best.total:.2f} found in {done.evaluations} evaluations, "
        f"seed {done.seed}; validated by drill-twin paper on {len(HELD_OUT)} other numbers and the trends"
    )


def to_dict(done: Calibration) -> dict[str, Any]:
    """Plain types for JSON."""
    return {
        "seed": done.seed, "evaluations": done.evaluations, "loss_at_start": done.start.total,
        "loss": done.best.total, "changes": done.changes, "deviations": done.best.deviations,
        "found": [found.to_dict() for found in done.found], "judged": [number.name for number in HELD_OUT],
        "tried": [loss.deviations for loss in done.tried],
    }  # fmt: skip
