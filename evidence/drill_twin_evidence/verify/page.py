# SPDX-License-Identifier: Apache-2.0
"""Results of a verification as a Markdown page and as plain data."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from itertools import groupby
from typing import Any

from drill_twin import __version__
from drill_twin.core.table import Table
from drill_twin_evidence.verify.not_validated import NOT_VALIDATED
from drill_twin_evidence.verify.row import Row
from drill_twin_evidence.verify.run import CaseResult

_HEAD = """# Verification

<!-- Written by `{command}`; do not edit. Run it again after a change of the physics. -->

Results of the twin beside closed forms and published numbers. Every row comes from a scene that the twin runs as any
other; the references are formulas, zeros and tables. A few rows are consistency checks, counted apart: their source
begins with *this twin*, and they show that two of its parts agree, not that either is right. The tolerance covers the
errors of mesh, time step and evaluation, which each case states. `drill-twin study verify` runs all cases on your
machine and ends with exit code 1 if a row misses its tolerance; the tests in `evidence/test/verify` run the same cases.

*Form* is the formulation: `spatial` with stretch and torsion, `lateral` without them
([design.md](../../docs/design.md)). Of each case and form, *of* is how many numbers were compared; the table has the
one nearest to its tolerance, and each one that misses it. All of them are in `verification.json`, in the repository
under `evidence/pages/`. Error and tolerance are relative to the expected number; with `abs` they are in its unit.

{summary}
"""


def summary(checks: Sequence[CaseResult]) -> str:
    """One line: number of rows within their tolerance, those of the twin beside itself apart.

    >>> summary([])
    'Nothing was run.'
    """
    rows = [row for check in checks for row in check.rows]
    if not checks:
        return "Nothing was run."
    own = [row for row in rows if row.is_consistency]
    others = [row for row in rows if not row.is_consistency]
    kinds = ((others, "of {} numbers beside formulas, zeros and tables"), (own, "of {} of the twin beside itself"))
    passed = " and ".join(f"{sum(row.ok for row in some)} {told.format(len(some))}" for some, told in kinds if some)
    failed = sum(bool(check.failure) for check in checks)
    text = f"{passed or 'no numbers'}, of {len(checks)} cases, are within their tolerance"
    return text + (f"; {failed} cases did not run." if failed else ".")


def to_data(checks: Sequence[CaseResult]) -> dict[str, Any]:
    """Plain types for JSON."""
    return {
        "version": __version__,
        "ok": all(check.ok for check in checks),
        "cases": [check.to_dict() for check in checks],
        "not_validated": [{"what": what, "why": why} for what, why in NOT_VALIDATED],
    }


def to_page(checks: Sequence[CaseResult], command: str) -> str:
    """The docs page, in Markdown.

    Args:
        checks: In the order of the page.
        command: Command line that writes it.
    """
    parts = [_HEAD.format(command=command, summary=summary(checks))]
    for topic, of_topic in groupby(checks, key=lambda check: check.case.topic):
        about = (import_module(f"drill_twin_evidence.verify.{topic}").__doc__ or topic).strip()
        parts.append(f"## {about.splitlines()[0].rstrip('.')}\n")
        for text, of_case in groupby(of_topic, key=lambda check: check.case.about):
            parts += [" ".join(text.split()) + "\n", *_table(list(of_case)), ""]
    parts.append("## Not validated\n")
    parts += [f"* **{what}**: {why}" for what, why in NOT_VALIDATED]
    return "\n".join(parts).rstrip() + "\n"


def _table(checks: Sequence[CaseResult]) -> list[str]:
    """Lines of the table of a case, one for each formulation; its references are printed above it."""
    references = list(dict.fromkeys(_reference(row) for check in checks for row in check.rows))
    columns = ("form", "of", "number nearest to its tolerance", "expected", "computed", "error", "tolerance", "")
    rows: list[tuple[object, ...]] = []
    for form, of_form in groupby(
        sorted(checks, key=lambda check: check.case.form, reverse=True), lambda c: c.case.form
    ):
        rows += _rows(form, list(of_form))
    table = Table(columns, rows, right=(1, 3, 4, 5, 6)).markdown()
    return [*([f"Reference: {'; '.join(references)}.\n"] if references else []), table]


def _rows(form: str, checks: Sequence[CaseResult]) -> list[tuple[object, ...]]:
    """Cases that did not run, numbers that miss their tolerance, and else the one that comes nearest to it."""
    failed = [(form, "", check.case.name, check.failure, "", "", "", "**miss**") for check in checks if check.failure]
    rows = [(check, row) for check in checks for row in check.rows]
    missed = [pair for pair in rows if not pair[1].ok]
    shown = (
        missed
        or sorted(rows, key=lambda pair: abs(pair[1].error) / pair[1].tolerance if pair[1].tolerance else 0.0)[-1:]
    )
    return failed + [
        (form, len(rows), f"{_variant(check)}{row.what}", number(row.expected), computed(row), error(row),
              tolerance(row), "ok" if row.ok else "**miss**")
        for check, row in shown
    ]  # fmt: skip


def _reference(row: Row) -> str:
    return f"`{row.reference}` ({row.source})"


def _variant(check: CaseResult) -> str:
    arguments = [f"{key} {value}".replace("_", " ") for key, value in check.case.arguments.items() if key != "form"]
    return f"{', '.join(arguments)}: " if arguments else ""


def number(value: float) -> str:
    """Six digits.

    >>> number(0.000123456789), number(0.0)
    ('0.000123457', '0')
    """
    return f"{value:.6g}"


def computed(row: Row) -> str:
    """Six digits; one digit where the expected number is zero."""
    return number(row.computed) if row.expected else f"{row.computed:.1g}"


def error(row: Row) -> str:
    """Two digits, relative or in the unit of the number; round-off as `< 1e-9`."""
    text = "0" if row.error == 0.0 else "< 1e-9" if abs(row.error) < 1e-9 else f"{row.error:.1e}"
    return text + ("" if row.relative else " abs")


def tolerance(row: Row) -> str:
    """Two digits, relative or in the unit of the number."""
    return f"{row.tolerance:.2g}" + ("" if row.relative else " abs")
