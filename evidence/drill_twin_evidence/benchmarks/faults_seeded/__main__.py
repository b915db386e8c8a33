# SPDX-License-Identifier: Apache-2.0
"""Seeded faults: put each into a copy of the package, and see which test catches it (`make faults-seeded`)."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Annotated, Any

import typer

from drill_twin.cli.emit import say
from drill_twin.core.table import Table
from drill_twin_evidence.benchmarks.faults_seeded.faults import FAULTS, Fault

ROOT = Path(__file__).parents[4]
COPIED = (
    "drill_twin",
    "companions",
    "test",
    "config",
    "docs",
    "evidence",
    "conftest.py",
    "pyproject.toml",
    "setup.py",
    "README.md",
)
TIMEOUT = 900.0
"""Time after which tests have not caught a fault [s]."""
_FAILED = re.compile(r"^(?:FAILED|ERROR) ([^\s\[]+)", re.MULTILINE)


def main(
    only: Annotated[str, typer.Option("--only", help="Faults with this text in their description.")] = "",
    folder: Annotated[Path, typer.Option("--out", help="Folder of the results; those in it are kept.")] = Path(
        "out/faults_seeded"
    ),
    page: Annotated[Path | None, typer.Option("--page", help="Write the table to this file, as Markdown.")] = None,
) -> None:
    """Run the tests of each fault without it and with it; ends with exit code 1 if one is not caught."""
    chosen = [fault for fault in FAULTS if only in fault.name]
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as place:
        copy = _copy(Path(place))
        for fault in chosen:
            result = folder / f"{_slug(fault.name)}.json"
            if not result.exists():
                result.write_text(json.dumps(_seeded(copy, fault), indent=2) + "\n", encoding="utf-8")
    results = {
        fault: json.loads(path.read_text("utf-8"))
        for fault in FAULTS
        if (path := folder / f"{_slug(fault.name)}.json").exists()
    }
    rows = [(fault.name, fault.file, found["caught_by"] or "NOT CAUGHT", f"{found['seconds']:.0f}")
            for fault, found in results.items()]  # fmt: skip
    say(Table(("fault", "file", "caught by", "s"), rows))
    if page is not None:
        page.write_text(_markdown(rows), encoding="utf-8")
    if any(not found["caught_by"] for found in results.values()):
        raise typer.Exit(1)


def _copy(place: Path) -> Path:
    for name in COPIED:
        source, target = ROOT / name, place / name
        if source.is_dir():
            shutil.copytree(source, target, ignore=shutil.ignore_patterns("__pycache__", "*.png"))
        else:
            shutil.copy2(source, target)
    return place


def _seeded(copy: Path, fault: Fault) -> dict[str, Any]:
    """Name of the first test that fails with the fault, and the time that takes [s].

    Raises:
        typer.BadParameter: The tests fail without the fault, or its text is not found once.
    """
    file = copy / fault.file
    text = file.read_text("utf-8")
    if text.count(fault.old) != 1:
        raise typer.BadParameter(f"{fault.name}: expected its text once in {fault.file}, found {text.count(fault.old)}")
    code, said = _tests(copy, fault)
    if code != 0:
        raise typer.BadParameter(f"{fault.name}: expected its tests to pass without it, found\n{said[-3000:]}")
    try:
        file.write_text(text.replace(fault.old, fault.new), encoding="utf-8")
        began = time.monotonic()
        code, said = _tests(copy, fault)
        seconds = time.monotonic() - began
    finally:
        file.write_text(text, encoding="utf-8")
    failed = _FAILED.search(said)
    return {"caught_by": failed[1] if code == 1 and failed else "", "seconds": seconds}


def _tests(copy: Path, fault: Fault) -> tuple[int, str]:
    """Exit code of pytest (1: a test failed) and what it says."""
    command = [sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", "-m", "long or not long"]
    environment = os.environ | {
        "PYTHONPATH": os.pathsep.join(map(str, (copy, copy / "evidence", *sorted((copy / "companions").iterdir())))),
        "ROS_PYTHON_CHECK_FIELDS": "1",
        "PYTHONDONTWRITEBYTECODE": "1",
    }
    try:
        ended = subprocess.run(
            [*command, *fault.command], cwd=copy, env=environment, capture_output=True, text=True, timeout=TIMEOUT,
            check=False,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        return -1, "the tests took too long"
    return ended.returncode, ended.stdout + ended.stderr


def _slug(name: str) -> str:
    return re.sub(r"\W+", "_", name)


def _markdown(rows: list[tuple[str, str, str, str]]) -> str:
    caught = sum("NOT" not in row[2] for row in rows)
    lines = [
        "# Seeded faults",
        "",
        "`make faults-seeded` puts small faults into a copy of the package, one at a time, and runs a few tests of the",
        "room that must catch each; without the fault the same tests pass. The faults are in",
        "`evidence/drill_twin_evidence/benchmarks/faults_seeded/faults.py`. The time is that of the tests up to the",
        "failure, compiling included.",
        f"Caught: {caught} of {len(rows)}.",
        "",
        Table(
            ("fault", "file", "caught by", "s"),
            ((name, f"`{file}`", f"`{test}`", seconds) for name, file, test, seconds in rows), right=(3,),
        ).markdown(),
    ]  # fmt: skip
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    typer.run(main)
