# SPDX-License-Identifier: Apache-2.0
"""Runs tasks one at a time, each in a process of its own, and puts the rounds together."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass
from importlib import import_module, metadata
from importlib.util import find_spec
from pathlib import Path
from statistics import median
from typing import NamedTuple

import numpy as np

from drill_twin.cli.show import remark
from drill_twin_evidence.benchmarks.peers.task import Motion, Task


class Tool(NamedTuple):
    """A tool and where it is."""

    adapter: str
    """Its module beside this one."""
    module: str
    """Name that it is imported as."""
    package: str
    """Name that pip has for it."""


TOOLS = {
    "drill_twin": Tool("drill_twin_rod", "drill_twin", "drill_twin"),
    "Exudyn ANCF": Tool("exudyn_cable", "exudyn", "exudyn"),
    "MuJoCo flex": Tool("mujoco_flex", "mujoco", "mujoco"),
    "PyElastica": Tool("pyelastica_rod", "elastica", "pyelastica"),
}
LONG = 20.0
"""Processor time from which a run is not repeated [s]."""
FIELDS = ("time", "path", "bottom", "reach", "cpu", "steps", "failure")
ALONE = {"EXUDYN_MODULE": "fast"} | dict.fromkeys(
    ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1"
)


@dataclass(frozen=True, eq=False)
class Outcome:
    """A task and what it showed, over all rounds."""

    task: Task
    motion: Motion
    """Of the first round."""
    costs: tuple[float, ...]
    """Processor time per simulated second of each round [s/s]."""

    @property
    def cost(self) -> float:
        """Median of the rounds [s/s]."""
        return median(self.costs)


def missing(tool: str) -> str | None:
    """Sentence on how to install a tool that is not there; None if it is."""
    if find_spec(TOOLS[tool].module):
        return None
    return f"{tool} is left out: not installed (pip install {TOOLS[tool].package}, or -e 'evidence[bench]')"


def usable(tools: Iterable[str]) -> list[str]:
    """Those that are there; of each other it is said how to install it."""
    found = []
    for tool in tools:
        why = missing(tool)
        if why is None:
            found.append(tool)
        else:
            remark(why, "yellow")
    return found


def versions(tools: Sequence[str]) -> dict[str, str]:
    """Versions of the tools that are there."""
    found = {}
    for tool in tools:
        try:
            found[tool] = metadata.version(TOOLS[tool].package)
        except metadata.PackageNotFoundError:
            found[tool] = "from source"
    return found


def run_rounds(tasks: Sequence[Task], rounds: int, progress: Callable[[str], None]) -> list[Outcome]:
    """Run every task once a round, in turn, so that a disturbance of the machine meets all tools."""
    motions: list[list[Motion]] = [[] for _ in tasks]
    for number in range(rounds):
        for task, found in zip(tasks, motions, strict=True):
            progress(f"round {number + 1} of {rounds}: {task.label}")
            if number and (found[0].failure or found[0].cpu > LONG):
                continue  # it would only fail again, or is long enough to be its own mean
            found.append(run_apart(task))
    return [
        Outcome(task, found[0], tuple(motion.cost for motion in found))
        for task, found in zip(tasks, motions, strict=True)
    ]


def run_apart(task: Task) -> Motion:
    """Run a task in a process of its own: no tool sees another's threads, caches or crashes."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "motion.npz"
        command = [
            sys.executable,
            "-m",
            "drill_twin_evidence.benchmarks.peers.run",
            json.dumps(asdict(task)),
            str(path),
        ]
        try:
            done = subprocess.run(
                command, env=os.environ | ALONE, capture_output=True, text=True, check=False,
                timeout=4.0 * task.limit + 240.0,
            )  # fmt: skip
            why = (done.stderr.strip().splitlines() or [f"exit status {done.returncode}"])[-1]
        except subprocess.TimeoutExpired:
            why = "no answer; ended from outside"
        if not path.is_file():
            nothing = np.empty(0)
            return Motion(nothing, np.empty((0, 2)), nothing, nothing, np.inf, 0, f"failed: {why}")
        with np.load(path) as file:
            arrays = {name: file[name] for name in FIELDS}
    return Motion(
        arrays["time"], arrays["path"], arrays["bottom"], arrays["reach"], float(arrays["cpu"]), int(arrays["steps"]),
        str(arrays["failure"]),
    )  # fmt: skip


def main() -> None:
    """The process of one task: its description and the file of the result as arguments."""
    task = Task(**json.loads(sys.argv[1]))
    motion = import_module(f"drill_twin_evidence.benchmarks.peers.{TOOLS[task.tool].adapter}").run(task)
    np.savez(sys.argv[2], **{name: getattr(motion, name) for name in FIELDS})


if __name__ == "__main__":
    main()
