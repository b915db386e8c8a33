# SPDX-License-Identifier: Apache-2.0
"""Count of the numeric constants and of the grounds they state; with a journal, what changes where each is varied.

    python -m drill_twin_evidence.detection.constants
    nice python -m drill_twin_evidence.detection.constants JOURNAL [--only FILE] [--first N] [--each N]

A variant that the journal has is not computed again. The table stands beside the journal as `.csv`.
"""

from __future__ import annotations

import argparse
import csv
from collections.abc import Sequence
from pathlib import Path

import drill_twin_studies
from drill_twin.core.files.json_files import JsonLines
from drill_twin_evidence.detection.constants.literals import CHOICES, Literal, counts, literals
from drill_twin_evidence.detection.constants.outcome import BASE, Outcome
from drill_twin_evidence.detection.constants.variation import FACTORS, PACKAGE, Row, copy_of_the_package, digest_of

WHIRL = PACKAGE / "whirl"
STUDIES = Path(drill_twin_studies.__file__).parent
FOLDERS = (
    ("whirl", WHIRL, ""), ("studies", PACKAGE / "studies", ""), ("estimation", STUDIES, "estimation"),
    ("fitting", STUDIES, "fitting"), ("maps", STUDIES, "maps"),
)  # fmt: skip
"""Folders that are counted: name, folder, and part of it."""
EACH = 4
"""Records of each kind, twice as many of the kinds with eight cases."""
FIGURES = ("half", "missed", "false", "f1", "marks")
"""Figures of an outcome whose change is printed."""
NOTHING = "changes nothing: goes or merges"


def choices(folder: Path, under: str = "") -> list[Literal]:
    """Literals that are a choice."""
    return [one for one in literals(folder, under) if one.use in CHOICES]


def count_table() -> str:
    """Counts of each folder, as a table in Markdown."""
    columns = {name: counts(literals(folder, under)) for name, folder, under in FOLDERS}
    lines = ["| literals but 0, 1, 2 | " + " | ".join(columns) + " |", "| --- |" + " ---: |" * len(columns)]
    lines += [
        f"| {row} | " + " | ".join(str(column[row]) for column in columns.values()) + " |"
        for row in next(iter(columns.values()))
    ]
    return "\n".join(lines)


def change(row: Row | None, base: Outcome) -> dict[str, object]:
    """Change of each figure, and what else is said otherwise; empty for a variant that is not there yet."""
    if row is None:
        return {}
    found = row["outcome"]
    if found is None:
        return {"changes": f"fails: {row['error']}"}
    figures = {name: round(found[name] - base[name], 4) for name in FIGURES}  # type: ignore[literal-required]
    parts = [part for part, digest in base["digests"].items() if found["digests"][part] != digest]
    return {**figures, "changes": " ".join(parts)}


def table(found: Sequence[Literal], rows: Sequence[Row]) -> list[dict[str, object]]:
    """One line for each varied literal: what it is, what it rests on, and what changes with half and double."""
    done = {(row["key"], row["factor"]): row for row in rows}
    base = next(row["outcome"] for row in rows if row["key"] == "as it is")
    lines = []
    for one in found:
        variants = [done.get((one.key, factor)) for factor in FACTORS]
        if base is None or None in variants:
            continue
        changes = [change(row, base) for row in variants]
        verdict = "" if any(each["changes"] for each in changes) else NOTHING
        line: dict[str, object] = {
            "file": one.file, "line": one.line, "name": one.name, "value": one.value, "use": one.use.value,
            "ground": one.ground.value, "verdict": verdict,
        }  # fmt: skip
        for factor, part in zip(FACTORS, changes, strict=True):
            line |= {f"{name} x{factor:g}": part.get(name, "") for name in (*FIGURES, "changes")}
        lines.append(line)
    return lines


def vary(journal: Path, only: str, first: int | None, each: int) -> list[dict[str, object]]:
    """Vary the constants of `whirl` that the journal lacks, write the table beside it, and return the table."""
    found = choices(WHIRL, only)[:first]
    file = JsonLines(journal, Row, "constants", {"whirl": digest_of(WHIRL), "base": BASE, "each": each})
    done = {(row["key"], row["factor"]) for row in file.results}
    wanted = [(one, factor) for one in found for factor in FACTORS if (one.key, factor) not in done]
    if wanted:
        with copy_of_the_package(each) as copy:
            row = copy.as_it_is()  # compiles what a variant does not change
            if row["outcome"] is None:
                raise SystemExit(f"the analysis as it is fails: {row['error']}")
            if ("as it is", 1.0) not in done:
                file.add(row)
            for number, (one, factor) in enumerate(wanted, 1):
                file.add(copy.varied(one, factor))
                print(f"{number} of {len(wanted)}: {one.key} {one.name} {one.text} x{factor:g}", flush=True)
    lines = table(found, file.results)
    if lines:
        with journal.with_suffix(".csv").open("w", encoding="utf-8", newline="") as stream:
            writer = csv.DictWriter(stream, list(lines[0]))
            writer.writeheader()
            writer.writerows(lines)
    return lines


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the counts, or vary."""
    parser = argparse.ArgumentParser(prog="python -m drill_twin_evidence.detection.constants", description=__doc__)
    parser.add_argument("journal", nargs="?", type=Path, help="file of results, .jsonl; without it only the counts")
    parser.add_argument(
        "--only", default="", metavar="FILE", help="only a file or folder of whirl/, such as criteria.py"
    )
    parser.add_argument("--first", type=int, metavar="N", help="only the first N of its constants")
    parser.add_argument("--each", type=int, default=EACH, metavar="N", help="records of each kind")
    asked = parser.parse_args(arguments)
    if asked.only and not (WHIRL / asked.only).exists():
        parser.error(f"--only: expected a file or folder of whirl/, found {asked.only}")
    print(count_table())
    if asked.journal is None:
        return
    lines = vary(asked.journal, asked.only, asked.first, asked.each)
    still = [line for line in lines if line["verdict"]]
    print(f"\n{len(lines)} varied, {len(still)} of them change nothing:")
    print("\n".join(f"{line['file']}:{line['line']} {line['name']} = {line['value']}" for line in still))


if __name__ == "__main__":
    main()
