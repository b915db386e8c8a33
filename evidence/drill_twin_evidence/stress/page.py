# SPDX-License-Identifier: Apache-2.0
"""Results of the hard cases as a Markdown page and as plain data."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby
from typing import Any

from drill_twin import __version__
from drill_twin.core.table import Table
from drill_twin_evidence.stress.run import Result
from drill_twin_evidence.verify.page import number
from drill_twin_evidence.verify.page import summary as verified
from drill_twin_evidence.verify.run import CaseResult

EXACT = (
    "buckling.euler", "rotor.whirl_driven_by_internal_damping", "contact.bounce_without_loss", "contact.restitution",
    "contact.pure_rolling", "contact.climbing", "stick_slip.cycle", "stick_slip.thresholds",
)  # fmt: skip
"""Cases of `drill-twin study verify` on the same physics."""

ALLOWED = 6  # index of the column of the allowed depth, too wide for a terminal
COLUMNS = ("scene", "form", "steps", "cut", "back", "depth", "law + step", "energy", "RTF", "")

_HEAD = """# Hard cases

<!-- Written by `{command}`; do not edit. Run it again after a change of physics or solver. -->

The scenes of `evidence/drill_twin_evidence/config/hard/`, each run to its end. `drill-twin study hard` does it on your
machine and ends with exit code 1 if one is not in order; `drill-twin run hard/load_300_n` runs one as any other scene.
{summary}

*Steps* is the number of time steps, *cut* that of steps halved because Newton's method did not converge, *back* that of
frames that the step guard rejected and repeated. *Depth* is the largest penetration of the wall in any frame [mm].
*Law* is the penetration that the contact law gives for a slice of the string at the speed and under the load of the
run, K d^(p+1) / (p+1) = m v^2 / 2 + q d; *step* is the displacement in half a step at that speed: where it is the
larger one, impacts are not resolved. *Energy* is the largest error of the energy balance (`numerics.audit`, here by
`--energy`) over the largest energy in motion. A run is in order if it ends with every number finite, a penetration
below law and step together, an energy error of at most a tenth, and no dissipative effect that adds energy; or, where
the motion cannot be computed, if it stops and names the reason. *RTF* is simulated over wall-clock time, two runs at a
time.

"""
_EXACT = """## With an exact answer

The same kernels at the same tolerances beside closed forms (bounces, rolling, climbing, growth, stick-slip), in
[verification.md](verification.md). """


def summary(results: Sequence[Result]) -> str:
    """One line: number of cases in order.

    >>> summary([])
    'Nothing was run.'
    """
    if not results:
        return "Nothing was run."
    return f"{sum(result.ok for result in results)} of {len(results)} cases are in order."


def cells(result: Result) -> tuple[str, ...]:
    """Cells of a row of the table."""
    wall = result.depth > 0.0
    return (
        result.name.partition("[")[0], result.form, str(result.steps), str(result.cut_steps), str(result.interventions),
        f"{result.depth * 1e3:.2g}" if wall else "-",
        f"{result.allowed * 1e3:.2g} + {result.travel * 1e3:.2g}" if wall else "-",
        "-" if result.energy is None else f"{result.energy:.1e}", f"{result.real_time_factor:.2g}",
        result.verdict.partition(":")[0] if result.ok else "MISS",
    )  # fmt: skip


def to_data(results: Sequence[Result], checks: Sequence[CaseResult] = ()) -> dict[str, Any]:
    """Plain types for JSON."""
    return {
        "version": __version__,
        "ok": all(result.ok for result in results) and all(check.ok for check in checks),
        "cases": [result.to_dict() for result in results],
        "exact": [check.to_dict() for check in checks],
    }


def to_page(results: Sequence[Result], checks: Sequence[CaseResult], command: str) -> str:
    """The docs page, in Markdown.

    Args:
        results: Results, in the order of the library.
        checks: Results of the cases with an exact answer.
        command: Command line that writes it.
    """
    text = _HEAD.format(command=command, summary=summary(results))
    text += Table(COLUMNS, map(cells, results), right=range(2, 9)).markdown() + "\n\n## Why they are hard\n\n"
    text += "\n".join(f"* `{name}`: {why}" for name, why in _reasons(results)) + "\n\n"
    if checks:
        text += "\n".join([_EXACT + verified(checks), *_missed(checks)]) + "\n\n"
    messages = [result for result in results if result.verdict != "ok"]
    if messages:
        text += "## Messages\n\n" + "\n".join(f"* `{result.name}`: {result.verdict}" for result in messages)
    return text.rstrip() + "\n"


def _reasons(results: Sequence[Result]) -> Iterator[tuple[str, str]]:
    for name, group in groupby(results, key=lambda result: result.name.partition("[")[0]):
        yield name, next(group).why


def _missed(checks: Sequence[CaseResult]) -> Iterator[str]:
    for check in checks:
        if check.failure:
            yield f"* **miss**: `{check.case.name}` did not run: {check.failure}"
        for row in check.rows:
            if not row.ok:
                found = f"expected {number(row.expected)}, computed {number(row.computed)}"
                yield f"* **miss**: `{check.case.name}`, {row.what}: {found}"
