# SPDX-License-Identifier: Apache-2.0
"""`python -m drill_twin_evidence.benchmarks.peers [PART ...]`: drill_twin beside its peers."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any

import typer

from drill_twin.cli.emit import say
from drill_twin.cli.show import remark, shown_progress
from drill_twin_evidence.benchmarks.peers.figure import draw
from drill_twin_evidence.benchmarks.peers.parts import PARTS, Part
from drill_twin_evidence.benchmarks.peers.rows import result
from drill_twin_evidence.benchmarks.peers.run import TOOLS, run_apart, run_rounds, usable
from drill_twin_evidence.benchmarks.peers.summary import summary
from drill_twin_evidence.benchmarks.peers.tables import markdown, note, table


def main(
    parts: Annotated[list[str] | None, typer.Argument(help=f"Any of {', '.join(PARTS)}; all if left out.")] = None,
    rounds: Annotated[int, typer.Option("--rounds", min=1, help="Times that each run is made; medians count.")] = 3,
    tools: Annotated[str, typer.Option("--tools", help="Comma-separated; all that are installed if left out.")] = "",
    folder: Annotated[Path, typer.Option("--out", help="Folder of the results.")] = Path("out/peers"),
    show: Annotated[bool, typer.Option("--show", help="Run nothing: print what the folder holds.")] = False,
) -> None:
    """Run the parts, print a table of each, and write PART.json, peers.md and peers.png."""
    names = parts or list(PARTS)
    for name in names:
        if name not in PARTS:
            raise typer.BadParameter(f"expected one of {', '.join(PARTS)}, found {name!r}")
    wanted = [tool for tool in TOOLS if not tools or tool.lower() in tools.lower().split(",")]
    folder.mkdir(parents=True, exist_ok=True)
    if not show:
        there = usable(wanted)
        for name in names:
            text = json.dumps(_measure(PARTS[name], there, rounds), indent=2)
            (folder / f"{name}.json").write_text(text + "\n", encoding="utf-8")
    results = [json.loads(path.read_text()) for name in PARTS if (path := folder / f"{name}.json").is_file()]
    for each in results:
        if each["part"] in names:
            say(table(each))
            say(note(each))
    in_short = summary(results)
    say(in_short)
    (folder / "peers.md").write_text("\n".join([in_short, *map(markdown, results)]), encoding="utf-8")
    if any(each["reference"] for each in results):
        draw(results, folder / "peers.png")
    remark(f"{folder}: peers.md, peers.png, *.json")


def _measure(part: Part, tools: list[str], rounds: int) -> dict[str, Any]:
    with shown_progress(part.title) as bar:

        def progress(line: str) -> None:
            bar.show(f"{part.name}: {line}")

        progress("reference")
        reference = run_apart(part.reference) if part.reference else None
        check = run_apart(part.check) if part.check and part.check.tool in tools else None
        outcomes = run_rounds([task for task in part.tasks if task.tool in tools], rounds, progress)
    return result(part, outcomes, reference, check, rounds)


if __name__ == "__main__":
    typer.run(main)
