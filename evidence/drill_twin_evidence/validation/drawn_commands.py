# SPDX-License-Identifier: Apache-2.0
"""`python -m drill_twin_evidence.validation.drawn_commands [COUNT] [--every]`: drawn plans through the commands.

Each plan goes through `modes` and a run of 10 s, with `--every` through each command that takes a scene, a run or a
record. Counted are tracebacks, warnings of Python, numbers that are no numbers, and sentences that each run prints.
"""

from __future__ import annotations

import re
import tempfile
import time
import warnings
from collections import Counter
from pathlib import Path
from typing import Annotated

import typer
from typer.testing import CliRunner

from drill_twin.cli.app import app
from drill_twin.core.errors import DrillTwinError
from drill_twin_evidence.validation.drawn_plans import plan

FIRST = (["modes", "SCENE"], ["run", "SCENE", "--duration", "10 s", "--out", "OUT/run"])
FREE = ("--free", "bit_torque_stribeck.sticking=0.2..1.2", "--free", "bit_torque_stribeck.sliding=0.1..1.0")
SHORT = ("--duration", "2 s")
EVERY = (
    ["scene", "check", "SCENE"], ["modes", "SCENE", "--count", "4", "--out", "OUT/modes"],
    ["statics", "SCENE", "--out", "OUT/statics"],
    ["statics", "SCENE", "--friction", "0.15..0.35:3", "--out", "OUT/depths"],
    ["analyze", "OUT/run"], ["report", "OUT/run", "--out", "OUT/report"],
    ["export", "OUT/run", "--csv", "--out", "OUT/csv"],
    ["rerun", "OUT/run", "--out", "OUT/again"],
    ["estimate", "OUT/run", "--scene", "SCENE", *FREE, "--channel", "torque", "--members", "4", "--horizon", "0 s"],
    ["fit", "OUT/run", "--scene", "SCENE", *FREE, "--channel", "torque", "--channel", "rotation", "--members", "8",
     "--rounds", "1", "--to", "3 s", "--rate", "10 Hz"],
    ["compare", "SCENE", "SCENE,wob=40 kN", "--repeats", "1", *SHORT, "--out", "OUT/compare"],
    ["whirl", "SCENE", "--starts", "0", "--out", "OUT/whirl"],
    ["modes", "SCENE", "--campbell", "5", "--out", "OUT/campbell"],
    ["map", "SCENE", "--wob", "20 kN..80 kN", "--rpm", "60..120 rpm", "--runs", "6", "--steps", "2", *SHORT,
     "--out", "OUT/map"],
    ["cost", "SCENE", "--elements", "60,90", "--repeats", "0", *SHORT, "--out", "OUT/cost"],
    ["effects", "SCENE", "--repeats", "2", "--duration", "1 s", "--out", "OUT/effects"],
)  # fmt: skip
"""Commands with small numbers: the least that makes each go its whole way."""
NOT_A_NUMBER = re.compile(r"(?<![\w/.-])nan(?![\w/-])", re.IGNORECASE)


class Tried(Counter[str]):
    """Outcomes of commands, by kind, and sentences by their head without numbers."""

    def __init__(self) -> None:
        super().__init__()
        self.sentences: Counter[str] = Counter()
        self.runs = 0

    def command(self, number: int, arguments: list[str], scene: Path, out: Path) -> None:
        """Try a command; print each failure."""
        told = [each.replace("SCENE", str(scene)).replace("OUT", str(out)) for each in arguments]
        began = time.process_time()
        with warnings.catch_warnings(record=True) as warned:
            warnings.simplefilter("always")
            done = CliRunner().invoke(app, told)
        name, error = " ".join(arguments[:2]).replace(" SCENE", "").replace(" OUT/run", ""), done.exception
        found = []
        if isinstance(error, DrillTwinError):
            found.append(f"refused: {error}")
        elif error is not None and not (isinstance(error, SystemExit) and not done.exit_code):
            found.append(f"traceback: {type(error).__name__}: {error}")
        found += [f"warning of Python: {one.category.__name__}: {one.message}" for one in warned]
        found += [f"nan: {line.strip()[:160]}" for line in done.output.splitlines() if NOT_A_NUMBER.search(line)]
        self.update([name.split()[0], *(f"{name}, {one.partition(':')[0]}" for one in found)])
        for one in found:
            print(f"plan {number}, {name}: {one[:400]}", flush=True)
        print(f"plan {number}, {name}: {time.process_time() - began:.1f} s of processor time", flush=True)
        if arguments[0] == "run":
            self.runs += 1
            text = re.sub(r"\s+", " ", done.output)
            heads = {re.sub(r"[\d.]+", "#", part)[:60] for part in re.findall(r"note: ([^;:.]{8,})", text)}
            self.sentences.update(heads | ({"not definite"} if "not definite" in text else set()))
            (out / "said.txt").write_text(done.output, "utf-8")


def main(
    count: Annotated[int, typer.Argument(help="Number of plans.")] = 20, first: int = 1, *, every: bool = False
) -> None:
    """Try plans, and print what fails, then the counts."""
    tried = Tried()
    for number in range(first, first + count):
        with tempfile.TemporaryDirectory() as folder:
            out = Path(folder)
            scene = out / "scene.yaml"
            scene.write_text(plan(number, out).scene()[0].to_yaml(), "utf-8")
            for arguments in (*FIRST, *(EVERY if every else ())):
                tried.command(number, arguments, scene, out)
    print(", ".join(f"{outcome}: {times}" for outcome, times in tried.items()))
    print(
        f"sentences of {tried.runs} runs: " + "; ".join(f"{head} ({times})" for head, times in tried.sentences.items())
    )


if __name__ == "__main__":
    typer.run(main)
