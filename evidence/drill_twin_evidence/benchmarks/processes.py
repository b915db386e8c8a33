# SPDX-License-Identifier: Apache-2.0
"""Nodes as child processes: each with its own log, ended in order, and never orphaned."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from drill_twin.core.errors import RunError
from drill_twin.core.process import child_environment
from drill_twin.ros.core.stop_request import END_WITH_PARENT

_SIGNAL_TIMEOUT = 10.0  # s after each signal, before the next and harsher one
_LOG_LINES = 8
_STARTING_TIME = 150.0  # s in which the nodes compile and connect; not measured


class Child:
    """Node in a process of its own."""

    def __init__(self, node: str, parameters: Mapping[str, object], environment: Mapping[str, str], log: Path) -> None:
        self.node = node
        self.log = log
        # JSON is YAML; a text is quoted, as it may look like a number.
        given = {name: json.dumps(value, ensure_ascii=False) for name, value in parameters.items()}
        arguments = [word for name, text in given.items() for word in ("-p", f"{name}:={text}")]
        command = [sys.executable, "-m", "drill_twin.ros", node, "--ros-args", *arguments]
        with log.open("wb") as stream:
            self._process = subprocess.Popen(
                command,
                env=child_environment({**environment, END_WITH_PARENT: str(os.getpid())}),
                stdin=subprocess.DEVNULL,
                stdout=stream,
                stderr=subprocess.STDOUT,
                start_new_session=True,  # Ctrl-C reaches the parent only, which ends its children in order
            )

    @property
    def pid(self) -> int:
        """Process id."""
        return self._process.pid

    @property
    def exit_code(self) -> int | None:
        """Exit code; None while it runs."""
        return self._process.poll()

    def wait(self, seconds: float) -> int | None:
        """Wait for its end, at most this long [s]; returns the exit code, None when it still runs."""
        try:
            return self._process.wait(max(seconds, 0.0))
        except subprocess.TimeoutExpired:
            return None

    def end(self) -> int:
        """End it: SIGINT, then SIGTERM, then SIGKILL; returns the exit code."""
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGKILL):
            if self.exit_code is None:
                self._process.send_signal(number)
                self.wait(_SIGNAL_TIMEOUT)
        return self._process.wait()

    def log_tail(self) -> str:
        """Last lines of its log."""
        lines = self.log.read_text("utf-8", "replace").strip().splitlines()
        return "\n".join(f"  {line}" for line in lines[-_LOG_LINES:])

    def check_alive(self) -> None:
        """Raise an error if the process has ended with one.

        Raises:
            RunError: It has; the message holds the end of its log.
        """
        if self.exit_code:
            raise RunError(
                f"{self.node} ended with exit code {self.exit_code}; the end of {self.log}:\n{self.log_tail()}"
            )


def twin_commands(
    simulator: Mapping[str, object], scene: Mapping[str, object], bag: Path
) -> dict[str, Mapping[str, object]]:
    """Nodes of a twin that is recorded, and their parameters, in the order in which they are ended: readers last."""
    return {
        "simulator": {**scene, **simulator},
        "rig_driver": {**scene, "wait_for": "simulator analyzer recorder", "wait_timeout": _STARTING_TIME},
        "analyzer": {},
        "recorder": {"bag": str(bag.absolute())},
    }


@contextmanager
def processes(
    commands: Mapping[str, Mapping[str, object]], environment: Mapping[str, str], logs: Path
) -> Iterator[dict[str, Child]]:
    """Run nodes as child processes, ended in order when the block is left, also by an error.

    Raises:
        RunError: On leaving without another error: a node ended with another exit code than 0.
    """
    children: dict[str, Child] = {}
    try:
        for node, parameters in commands.items():  # a signal may come before the last of them is there
            children[node] = Child(node, parameters, environment, logs / f"{node}.log")
        yield children
    finally:
        codes = {node: child.end() for node, child in children.items()}
    for node, code in codes.items():
        if code:
            raise RunError(
                f"{node} ended with exit code {code}; its log, {children[node].log}, ends with\n"
                f"{children[node].log_tail()}"
            )
