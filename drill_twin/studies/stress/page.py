# SPDX-License-Identifier: Apache-2.0
"""The hard cases as a page for the docs and as plain data."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby
from typing import Any

from drill_twin import __version__
from drill_twin.studies.stress.judge import Result
from drill_twin.studies.verify.page import computed, error, number, tolerance
from drill_twin.studies.verify.run import Outcome

EXACT = (
    "buckling.euler", "rotor.whirl_driven_by_internal_damping", "contact.bounce_without_loss", "contact.restitution",
    "contact.pure_rolling", "contact.climbing", "stick_slip.cycle", "stick_slip.thresholds",
)  # fmt: skip
"""Exact checks (`drill-twin verify`) of what the hard scenes are about."""

ALLOWED = 6  # place of the depth that is allowed, too wide for a terminal
COLUMNS = ("scene", "form", "steps", "cut", "back", "depth", "law + step", "energy", "RTF", "")

_HEAD = """# Hard cases

<!-- Written by `{command}`; do not edit. Whoever changes physics or solver runs it again. -->

The scenes of `config/hard/`, each run to its end. `drill-twin hard` does it on your machine and ends with exit code 1
if one is not in order; `drill-twin run hard/load_300_n` runs one as any other scene. {summary}

*Steps* are those taken, *cut* those halved because Newton's method did not converge, *back* the frames that the guard
had done again. *Depth* is the deepest penetration of the wall in any frame [mm]. *Law* is what the law of the wall
gives a slice of the string at the speed and under the load that occurred, K d^(p+1) / (p+1) = m v^2 / 2 + q d; *step*
is what half a step adds at that speed: where it is the larger one, impacts are not resolved. *Energy* is the largest
part that nothing accounts for in the audit (`numerics.audit`, here by `--energy`), of the largest energy on the move. A
run is in order if it comes to its end with every number finite, no deeper than law and step together, at most a tenth
of the energy not accounted for, and no effect that dissipates giving any; or, where nothing could follow the motion, if
it stops and names the reason. *RTF* is simulated over wall-clock seconds, two runs at a time.

"""
_EXACT = """## With an exact answer

What the same kernels compute at the same tolerances, beside closed forms; the whole list is in
[verification.md](verification.md).

"""


def summary(results: Sequence[Result]) -> str:
    """One line.

    >>> summary([])
    'Nothing was run.'
    """
    if not results:
        return "Nothing was run."
    return f"{sum(result.ok for result in results)} of {len(results)} cases are in order."


def cells(result: Result) -> tuple[str, ...]:
    """A line of the table."""
    wall = result.depth > 0.0
    return (
        result.name.partition("[")[0], result.form, str(result.steps), str(result.cut_steps), str(result.interventions),
        f"{result.depth * 1e3:.2g}" if wall else "-",
        f"{result.allowed * 1e3:.2g} + {result.travel * 1e3:.2g}" if wall else "-",
        "-" if result.energy is None else f"{result.energy:.1e}", f"{result.real_time_factor:.2g}",
        result.verdict.partition(":")[0] if result.ok else "MISS",
    )  # fmt: skip


def to_data(results: Sequence[Result], outcomes: Sequence[Outcome] = ()) -> dict[str, Any]:
    """Plain types for JSON."""
    return {
        "version": __version__,
        "ok": all(result.ok for result in results) and all(outcome.ok for outcome in outcomes),
        "cases": [result.to_dict() for result in results],
        "exact": [outcome.to_dict() for outcome in outcomes],
    }


def to_page(results: Sequence[Result], outcomes: Sequence[Outcome], command: str) -> str:
    """The docs page, in Markdown.

    Args:
        results: In the order of the library.
        outcomes: Of the exact checks.
        command: What writes it.
    """
    lines = [_line(*COLUMNS), _line(*["---"] * len(COLUMNS)), *(_line(*cells(result)) for result in results)]
    text = _HEAD.format(command=command, summary=summary(results))
    text += "\n".join(lines) + "\n\n## Why they are hard\n\n"
    text += "\n".join(f"* `{name}`: {why}" for name, why in _reasons(results)) + "\n\n"
    if outcomes:
        columns = ("check", "form", "number", "reference", "expected", "computed", "error", "tolerance", "")
        text += _EXACT + "\n".join([_line(*columns), _line(*["---"] * len(columns)), *_exact(outcomes)]) + "\n\n"
    said = [result for result in results if result.verdict != "ok"]
    if said:
        text += "## What was said\n\n" + "\n".join(f"* `{result.name}`: {result.verdict}" for result in said)
    return text.rstrip() + "\n"


def _reasons(results: Sequence[Result]) -> Iterator[tuple[str, str]]:
    for name, group in groupby(results, key=lambda result: result.name.partition("[")[0]):
        yield name, next(group).why


def _exact(outcomes: Sequence[Outcome]) -> Iterator[str]:
    for outcome in outcomes:
        if outcome.failure:
            yield _line(outcome.case.name, outcome.case.form, outcome.failure, "", "", "", "", "", "**miss**")
        for row in outcome.rows:
            yield _line(
                outcome.case.name.partition("[")[0], outcome.case.form, row.what, f"`{row.reference}` ({row.source})",
                number(row.expected), computed(row), error(row), tolerance(row), "ok" if row.ok else "**miss**",
            )  # fmt: skip


def _line(*values: str) -> str:
    return "| " + " | ".join(" ".join(value.split()).replace("|", "\\|") for value in values) + " |"
