# SPDX-License-Identifier: Apache-2.0
"""Processor time that a command takes to start, and to compile a scene.

    python -m drill_twin_evidence.benchmarks.start
    python -m drill_twin_evidence.benchmarks.start --beside ../before/.venv/bin/python

Each figure is the least of several new processes, user and system time [s]. With `--beside` the commands of another
installation take turns with the commands of this one.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
from collections import defaultdict
from pathlib import Path
from typing import Annotated

import typer

from drill_twin.cli.emit import emit
from drill_twin.cli.options import JsonOption
from drill_twin.cli.show import shown_progress
from drill_twin.core.table import Table

COMMAND = "import sys; from drill_twin.cli import main; sys.argv[0] = 'drill-twin'; main()"
WARM: dict[str, tuple[str, ...]] = {
    "drill-twin scene list": (COMMAND, "scene", "list"),
    "import drill_twin as dt; dt.Simulation": ("import drill_twin as dt; dt.Simulation",),
    "drill-twin run pa6_bench --duration 1": (COMMAND, "run", "pa6_bench", "--duration", "1"),
    "drill-twin run pa6_bench": (COMMAND, "run", "pa6_bench"),
}
COLD: dict[str, tuple[str, ...]] = {
    "compile pa6_bench": (COMMAND, "run", "pa6_bench", "--duration", "1"),
    "then a second set of effects": (COMMAND, "run", "pa6_bench", "--duration", "1", "--set", "effects.gravity=off"),
    "then a known set": (COMMAND, "run", "pa6_bench", "--duration", "1", "--set", "numerics.elements=17"),
}


def processor_time(python: str, arguments: tuple[str, ...], cache: Path | None = None) -> float:
    """Processor time of one process [s], with the user's cache of compiled kernels or one of its own.

    Raises:
        subprocess.CalledProcessError: The command failed.
    """
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    if cache is not None:
        environment["DRILL_TWIN_CACHE"] = str(cache)
    with tempfile.TemporaryDirectory() as folder:
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run((python, "-c", *arguments), cwd=folder, env=environment, check=True, capture_output=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def start(
    beside: Annotated[Path | None, typer.Option("--beside", help="Interpreter of the other installation.")] = None,
    repeats: Annotated[int, typer.Option("--repeats", help="Processes of each row; compiling takes two.", min=1)] = 5,
    json: JsonOption = False,
) -> None:
    """Print the processor time of a few commands, with compiled kernels in the cache and without."""
    pythons = [sys.executable, *([str(beside)] if beside else [])]
    found: defaultdict[tuple[str, str], list[float]] = defaultdict(list)
    with shown_progress("starting") as bar:
        for number in range(repeats + 1):
            for name, arguments in WARM.items():
                bar.show(name)
                for python in pythons:
                    seconds = processor_time(python, arguments)
                    found[name, python] += [seconds] if number else []  # the first fills the cache
        for _ in range(min(repeats, 2)):
            for python in pythons:
                with tempfile.TemporaryDirectory() as cache:
                    for name, arguments in COLD.items():
                        bar.show(name)
                        found[name, python].append(processor_time(python, arguments, Path(cache)))
    least = {name: [min(found[name, python]) for python in pythons] for name in (*WARM, *COLD)}
    header = ("processor time [s]", "here", *(["there"] if beside else []))
    rows = [(name, *(f"{seconds:.2f}" for seconds in row)) for name, row in least.items()]
    emit(least, [Table(header, rows, right=(1, 2)[: len(pythons)])], json=json)


if __name__ == "__main__":
    typer.run(start)
