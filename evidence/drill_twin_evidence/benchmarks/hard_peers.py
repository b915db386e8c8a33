# SPDX-License-Identifier: Apache-2.0
"""Hard cases side by side: `python -m drill_twin_evidence.benchmarks.hard_peers`.

Each case is the peers' rod with one thing made hard. drill_twin runs with its own choice of step, Exudyn with 1 ms and
its adaptive steps, PyElastica with 5 us, half of what linear stability allows. A run is right if it ends, and the
rise of its bottom, mean of the second half, is that of a drill_twin run with twice the elements and steps of 0.25 ms,
to 5 % or 1 mm: where the motion is chaotic, no path can be compared. Whoever doubts that judge may take another: all
rises are printed.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import typer

from drill_twin.cli.emit import say
from drill_twin.cli.show import shown_progress
from drill_twin.core.table import Table
from drill_twin_evidence.benchmarks.peers.parts import EXUDYN, MS, OURS, PYELASTICA
from drill_twin_evidence.benchmarks.peers.rows import row
from drill_twin_evidence.benchmarks.peers.run import Outcome, run_apart, usable
from drill_twin_evidence.benchmarks.peers.tables import remark, speed
from drill_twin_evidence.benchmarks.peers.task import Task

NO_RAMP = {"rig.weight_on_bit.duration": "0 s", "rig.weight_on_bit.start": "1 s"}
CASES: dict[str, Mapping[str, str]] = {
    "300 N": {"wob": "300 N"},
    "1,000 N": {"wob": "1000 N"},
    "6.5 rev/s": {"rpm": "6.5 rev/s"},
    "20 rev/s": {"rpm": "20 rev/s"},
    "300 N in one sample, at 1 rev/s": {**NO_RAMP, "wob": "300 N", "rpm": "1 rev/s"},
    "300 N taken off in one sample": {**NO_RAMP, "rig.weight_on_bit.initial": "300 N", "wob": "0 N"},
    "speed reversed within 0.1 s": {
        "rig.rotation.initial": "2 rev/s", "rig.rotation.value": "-2 rev/s", "rig.rotation.start": "1.5 s",
        "rig.rotation.duration": "0.1 s",
    },
    "wall of 1e3 N/m^2.5": {"effects.wall.stiffness": "1e3 N/m^2.5"},
    "wall of 1e10 N/m^2.5": {"effects.wall.stiffness": "1e10 N/m^2.5"},
    "wall of 1e12 N/m^2.5": {"effects.wall.stiffness": "1e12 N/m^2.5"},
    "wall that loses nothing": {"effects.wall.restitution": "1"},
    "no friction": {"effects.wall_friction.coefficient": "0"},
    "friction of 2, sharp": {"effects.wall_friction.coefficient": "2", "effects.wall_friction.accuracy": "1e6 s/m"},
    "clearance of 0.1 mm": {"hole.radius": "8.35 mm"},
    "clearance of 1 m": {"hole.radius": "1.00825 m"},
}  # fmt: skip
STEPS = {OURS: 0.0, EXUDYN: 1.0 * MS, PYELASTICA: 0.005 * MS}
HEADS = ("case", "rise expected")
CLOSE, SMALL = 0.05, 1e-3


def main(
    only: Annotated[str, typer.Option("--only", help="Comma-separated: cases that hold one of these texts.")] = "",
    duration: Annotated[str, typer.Option("--duration", help="Simulated time of a case.")] = "3 s",
    limit: Annotated[float, typer.Option("--limit", help="Processor time a run may take [s].")] = 60.0,
    folder: Annotated[Path, typer.Option("--out", help="Folder of the results.")] = Path("out/hard_peers"),
) -> None:
    """Run the cases by each tool that is installed; print a table, and write it as JSON and Markdown."""
    tools = usable(STEPS)
    folder.mkdir(parents=True, exist_ok=True)
    found = []
    with shown_progress("running") as bar:
        for name, changes in CASES.items():
            if any(text.strip() in name for text in only.split(",")):
                bar.show(name)
                found.append(judge(name, {"duration": duration, **changes}, tools, limit))
                _write(folder, found, tools)
    say(_table(found, tools))


def _write(folder: Path, found: list[dict[str, Any]], tools: list[str]) -> None:
    """After each case, so that a run that is broken off leaves what it has."""
    (folder / "hard_peers.json").write_text(json.dumps(found, indent=2) + "\n", encoding="utf-8")
    (folder / "hard_peers.md").write_text(_table(found, tools).markdown() + "\n", encoding="utf-8")


def _table(found: list[dict[str, Any]], tools: list[str]) -> Table:
    rows = [cells(case, tools) for case in found]
    return Table((*HEADS, *tools), rows, title="Hard cases: verdict, and simulated over processor time")


def judge(name: str, changes: Mapping[str, str], tools: list[str], limit: float) -> dict[str, Any]:
    """Run a case by all tools and say of each whether it was right."""
    fine = Task(OURS, 100, 0.25 * MS, changes=changes, limit=600.0)
    expected = row(Outcome(fine, motion := run_apart(fine), (motion.cost,)), None, 0.0)
    case: dict[str, Any] = {"case": name, "expected_rise_m": expected["mean_rise_m"], "reference": expected}
    for tool in tools:
        task = Task(tool, 50, STEPS[tool], changes=changes, limit=limit)
        motion = run_apart(task)
        case[tool] = row(Outcome(task, motion, (motion.cost,)), None, 0.0)
        case[tool]["verdict"] = verdict(case[tool], expected)
    return case


def verdict(found: Mapping[str, Any], expected: Mapping[str, Any]) -> str:
    """In a few words."""
    if found["failure"]:
        return remark(found)
    rise = f"{1e3 * found['mean_rise_m']:.1f} mm"
    if expected["failure"]:
        return f"ended, {rise}"
    apart = abs(found["mean_rise_m"] - expected["mean_rise_m"])
    return f"{'right' if apart <= max(CLOSE * abs(expected['mean_rise_m']), SMALL) else 'off'}, {rise}"


def cells(case: Mapping[str, Any], tools: list[str]) -> list[str]:
    """A line of the table."""
    rise = case["expected_rise_m"]
    line = [case["case"], "" if rise is None else f"{1e3 * rise:.1f} mm"]
    for tool in tools:
        factor = f", {speed(1.0 / case[tool]['cost'])} x real time" if case[tool]["cost"] else ""
        line.append(f"{case[tool]['verdict']}{factor}")
    return line


if __name__ == "__main__":
    typer.run(main)
