# SPDX-License-Identifier: Apache-2.0
"""The command line, in this process and as a process of its own."""

import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

from drill_twin.cli import run_command

PACKAGE = Path(__file__).resolve().parents[1]


@dataclass
class Said:
    """How a command ended."""

    code: int
    out: str
    err: str


def environment() -> dict[str, str]:
    """The environment of a child that finds this source tree, with a terminal wide enough."""
    path = os.pathsep.join(filter(None, (str(PACKAGE), os.environ.get("PYTHONPATH"))))
    return dict(os.environ, PYTHONPATH=path, COLUMNS="160", PYTHONUNBUFFERED="1")


@pytest.fixture
def inside(tmp_path, monkeypatch) -> Path:
    """An empty working folder."""
    (tmp_path / "work").mkdir()
    monkeypatch.chdir(tmp_path / "work")
    return tmp_path / "work"


@pytest.fixture
def call(inside, capsys, monkeypatch) -> Callable[..., Said]:
    """Run a command in this process."""
    monkeypatch.setenv("COLUMNS", "160")

    def run(*arguments: object) -> Said:
        code = run_command([str(argument) for argument in arguments])
        said = capsys.readouterr()
        return Said(code, said.out, said.err)

    return run


@pytest.fixture
def process(inside) -> Callable[..., Said]:
    """Run a command as a process of its own, to its end."""

    def run(*arguments: object) -> Said:
        command = [sys.executable, "-m", "drill_twin.cli", *map(str, arguments)]
        done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False, env=environment())
        return Said(done.returncode, done.stdout, done.stderr)

    return run


@pytest.fixture
def start(inside) -> Callable[..., subprocess.Popen[str]]:
    """Start a command as a process of its own; it is ended with the test."""
    started: list[subprocess.Popen[str]] = []

    def begin(*arguments: object) -> subprocess.Popen[str]:
        command = [sys.executable, "-m", "drill_twin.cli", *map(str, arguments)]
        child = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment())
        started.append(child)
        return child

    yield begin
    for child in started:
        if child.poll() is None:
            child.kill()
        child.communicate()
