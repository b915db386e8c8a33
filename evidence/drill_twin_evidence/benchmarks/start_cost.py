# SPDX-License-Identifier: Apache-2.0
"""Processor time of starts and compilations, of this tree beside another one, measured in turn.

    python -m drill_twin_evidence.benchmarks.start_cost --against ../before

Each command is a process of its own with the sources of its tree; user and system time of it and of its children, the
least of several. Kernels lie in a folder of each tree, which is empty at first.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Annotated

import typer

from drill_twin.cli.emit import emit
from drill_twin.cli.options import JsonOption
from drill_twin.core.table import Table

HERE = Path(__file__).parents[3]
_RUN = ("-m", "drill_twin.cli", "run", "pa6_bench", "--out", "{folder}/bag", "--replace")
_SESSION = (
    "import sys; from drill_twin.scene import load_scene; from drill_twin.runs import Session; "
    "Session(load_scene('pa6_bench', overrides=dict(item.split('=') for item in sys.argv[1:])))"
)
STARTS = {
    "first compilation of pa6_bench": ("-c", _SESSION),
    "another set of effects": ("-c", _SESSION, "effects.bow=off"),
    "a known set of effects": ("-c", _SESSION),
    "run of 1 s": (*_RUN, "--duration", "1"),
    "run of 30 s with a report": (*_RUN, "--wob", "40 N", "--rpm", "120", "--duration", "30", "--report"),
    "scene list": ("-m", "drill_twin.cli", "scene", "list"),
    "import of Simulation": ("-c", "import drill_twin as dt; dt.Simulation"),
}
"""Arguments of Python by what they do, in an order in which later ones find what they need compiled."""


def processor_time(tree: Path, arguments: tuple[str, ...], folder: Path) -> float:
    """User and system time [s] of a process with the sources of a tree; its kernels are in the folder."""
    packages = (tree, tree / "evidence", *sorted((tree / "companions").glob("drill_twin_*")))
    changes = {"PYTHONPATH": os.pathsep.join(map(str, packages)), "DRILL_TWIN_CACHE": str(folder / "kernels")}
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = [sys.executable, *(argument.format(folder=folder) for argument in arguments)]
    subprocess.run(command, env=os.environ | changes, cwd=folder, stdout=subprocess.DEVNULL, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime


def main(
    against: Annotated[Path | None, typer.Option(help="Root folder of another tree of sources.")] = None,
    repeat: Annotated[int, typer.Option(min=1, help="Processes of each kind; the least time counts.")] = 5,
    json: JsonOption = False,
) -> None:
    """Print processor times of starts, of this tree and of another one."""
    trees = [HERE] if against is None else [HERE, against.resolve()]
    rows = []
    with tempfile.TemporaryDirectory() as place:
        folders = [Path(place) / str(number) for number in range(len(trees))]
        for folder in folders:
            folder.mkdir()
        for name, arguments in STARTS.items():
            times: list[list[float]] = [[] for _ in trees]
            for _ in range(1 if name in list(STARTS)[:2] else repeat):
                for tree, folder, found in zip(trees, folders, times, strict=True):
                    found.append(processor_time(tree, arguments, folder))
            rows.append((name, *(f"{min(found):.2f} s" for found in times)))
    headings = ("start", "this tree", *(str(tree) for tree in trees[1:]))
    data = [dict(zip(headings, row, strict=True)) for row in rows]
    emit(data, [Table(headings, rows, right=(1, 2)[: len(trees)])], json=json)


if __name__ == "__main__":
    typer.run(main)
