# SPDX-License-Identifier: Apache-2.0
"""The outcome of a verification as a page for the docs and as plain data."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from itertools import groupby
from typing import Any

from drill_twin import __version__
from drill_twin.studies.verify.not_validated import MISSING
from drill_twin.studies.verify.row import Row
from drill_twin.studies.verify.run import Outcome

_HEAD = """# Verification

<!-- Written by `{command}`; do not edit. Whoever changes physics runs it again. -->

What the twin computes, beside closed forms and published numbers. Every row is a scene that is run by the twin as any
other; what is compared with it are formulas, zeros and tables only. The tolerance is what elements, step and reading
explain, and each case says why. `drill-twin verify` runs all of this on your machine and ends with exit code 1 if a row
misses; the tests in `test/studies/verify` run the same cases.

*Form* is how the string is computed: `spatial` with stretch and torsion, `lateral` without them
([design.md](design.md)). Error and tolerance are shares of the expected number; with `abs` they are in its unit.

{summary}
"""


def summary(outcomes: Sequence[Outcome]) -> str:
    """One line: how many rows hold.

    >>> summary([])
    'Nothing was run.'
    """
    rows = [row for outcome in outcomes for row in outcome.rows]
    if not outcomes:
        return "Nothing was run."
    held = sum(row.ok for row in rows)
    failed = sum(bool(outcome.failure) for outcome in outcomes)
    said = f"{held} of {len(rows)} numbers of {len(outcomes)} cases are within their tolerance"
    return said + (f"; {failed} cases did not run." if failed else ".")


def to_data(outcomes: Sequence[Outcome]) -> dict[str, Any]:
    """Plain types for JSON."""
    return {
        "version": __version__,
        "ok": all(outcome.ok for outcome in outcomes),
        "cases": [outcome.to_dict() for outcome in outcomes],
        "not_validated": [{"what": what, "why": why} for what, why in MISSING],
    }


def to_page(outcomes: Sequence[Outcome], command: str) -> str:
    """The docs page, in Markdown.

    Args:
        outcomes: In the order of the page.
        command: What writes it.
    """
    parts = [_HEAD.format(command=command, summary=summary(outcomes))]
    for topic, of_topic in groupby(outcomes, key=lambda outcome: outcome.case.topic):
        about = (import_module(f"drill_twin.studies.verify.{topic}").__doc__ or topic).strip()
        parts.append(f"## {about.splitlines()[0].rstrip('.')}\n")
        for text, of_case in groupby(of_topic, key=lambda outcome: outcome.case.about):
            parts += [" ".join(text.split()) + "\n", *_table(list(of_case)), ""]
    parts.append("## Not validated\n")
    parts += [f"* **{what}**: {why}" for what, why in MISSING]
    return "\n".join(parts).rstrip() + "\n"


def _table(outcomes: Sequence[Outcome]) -> list[str]:
    """Lines of the table of a case; a reference that all numbers share stands above it."""
    references = {_reference(row) for outcome in outcomes for row in outcome.rows}
    shared = len(references) == 1
    columns = ["number", "form", *([] if shared else ["reference"]), "expected", "computed", "error", "tolerance", ""]
    lines = [f"Reference: {references.pop()}.\n"] if shared else []
    lines += [_line(*columns), _line(*["---"] * len(columns))]
    for outcome in outcomes:
        if outcome.failure:
            lines.append(_line(outcome.case.name, outcome.case.form, outcome.failure, *[""] * (len(columns) - 4),
                               "**miss**"))  # fmt: skip
        lines += [
            _line(
                f"{_variant(outcome)}{row.what}", outcome.case.form, *([] if shared else [_reference(row)]),
                number(row.expected), computed(row), error(row), tolerance(row), "ok" if row.ok else "**miss**",
            )
            for row in outcome.rows
        ]  # fmt: skip
    return lines


def _reference(row: Row) -> str:
    return f"`{row.reference}` ({row.source})"


def _variant(outcome: Outcome) -> str:
    words = [f"{key} {value}".replace("_", " ") for key, value in outcome.case.arguments.items() if key != "form"]
    return f"{', '.join(words)}: " if words else ""


def _line(*cells: str) -> str:
    return "| " + " | ".join(" ".join(cell.split()).replace("|", "\\|") for cell in cells) + " |"


def number(value: float) -> str:
    """Six digits.

    >>> number(0.000123456789), number(0.0)
    ('0.000123457', '0')
    """
    return f"{value:.6g}"


def computed(row: Row) -> str:
    """As the expected number; two digits of what should be nothing."""
    return number(row.computed) if row.expected else f"{row.computed:.1g}"


def error(row: Row) -> str:
    """Two digits, as a share or in the number's unit; what is round-off is not told apart."""
    told = "0" if row.error == 0.0 else "< 1e-9" if abs(row.error) < 1e-9 else f"{row.error:.1e}"
    return told + ("" if row.relative else " abs")


def tolerance(row: Row) -> str:
    """As `error`."""
    return f"{row.tolerance:.2g}" + ("" if row.relative else " abs")
