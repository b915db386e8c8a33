# SPDX-License-Identifier: Apache-2.0
"""Processes of nodes and commands that begin with their imports done: forked from one process that has made them.

Most of the processor time of the start of a node are imports and the loading of the paper's kernel (2.2 s, 0.4 s when
forked). What is started here is a process of its own, with its own arguments, environment, log and exit code, and ends
as any interpreter does; what it lacks is the start of Python itself, which `test_start_and_stop.py` has for each node.
"""

from __future__ import annotations

import gc
import json
import os
import runpy
import select
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

OWN = frozenset({"ROS_DOMAIN_ID", "ROS_LOG_DIR", "PYTEST_CURRENT_TEST"})
"""Variables in which a forked process may differ from the one that made the imports."""
_POLL = 0.01  # s between two looks at what has ended


class WarmPopen:
    """A process forked by a `Warmed`; the part of `subprocess.Popen` that tests use."""

    def __init__(self, pid: int, ended: Path) -> None:
        self.pid = pid
        self._ended = ended

    def poll(self) -> int | None:
        """Exit code, negative for a signal; None while it runs."""
        return int(self._ended.read_text("ascii")) if self._ended.exists() else None

    def send_signal(self, number: int) -> None:
        """Send a signal, unless it has ended."""
        if self.poll() is None:
            with suppress(ProcessLookupError):  # it has ended now
                os.kill(self.pid, number)

    def kill(self) -> None:
        """End it at once."""
        self.send_signal(signal.SIGKILL)

    def wait(self, timeout: float | None = None) -> int:
        """Wait for its exit code."""
        end = time.monotonic() + (3600.0 if timeout is None else timeout)
        while (code := self.poll()) is None:
            if time.monotonic() > end:
                raise subprocess.TimeoutExpired("node", timeout or 0.0)
            time.sleep(_POLL)
        return code


class Warmed:
    """The process that has made the imports, from the first use on."""

    def __init__(self) -> None:
        self._environment: dict[str, str] = {}
        self._process: subprocess.Popen[str] | None = None

    def prepare(self, environment: dict[str, str]) -> None:
        """Take the environment of the imports, the first time."""
        self._environment = self._environment or dict(environment)

    def fits(self, environment: dict[str, str]) -> bool:
        """A process with this environment may be forked: its imports would be the same."""
        keys = {*environment, *self._environment} - OWN
        return all(environment.get(key) == self._environment.get(key) for key in keys)

    def start(self, arguments: list[str], environment: dict[str, str], log: Path) -> WarmPopen:
        """A process of `python -m` with a module and its arguments, in the folder of its log."""
        if self._process is None:
            command, pipe = [sys.executable, __file__], subprocess.PIPE
            self._process = subprocess.Popen(command, env=self._environment, text=True, stdin=pipe, stdout=pipe)
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        print(json.dumps([arguments, environment, str(log)]), file=self._process.stdin, flush=True)
        return WarmPopen(int(self._process.stdout.readline()), _ended(log))

    def close(self) -> None:
        """End it, and all that it has forked."""
        if self._process is not None:
            assert self._process.stdin is not None
            self._process.stdin.close()
            self._process.wait()


def _ended(log: Path) -> Path:
    return log.with_suffix(".exit_code")


def _import_all() -> None:
    """Make the imports of every node, also those that it makes late, and load the kernels of the paper's scene."""
    import importlib
    import importlib.util
    import pkgutil

    from drill_twin.core.companions import COMPANIONS
    from drill_twin.runs import Session
    from drill_twin.scene import load_scene

    installed = (companion.name for companion in COMPANIONS if importlib.util.find_spec(companion.name))
    for nodes in (importlib.import_module(f"{package}.ros") for package in ("drill_twin", *installed)):
        for module in pkgutil.walk_packages(nodes.__path__, f"{nodes.__name__}."):
            if not module.name.endswith("__main__"):
                importlib.import_module(module.name)
    if importlib.util.find_spec("drill_twin_rig"):
        importlib.import_module("drill_twin_rig.gateway.opc_ua.server")
    Session(load_scene("pa6_bench"))


def _serve(replies: int) -> list[str]:
    """Fork a process for each request; returns in the forked one only, with its module and arguments."""
    logs: dict[int, Path] = {}
    while True:
        asked, _, _ = select.select([0], [], [], _POLL)
        while logs and (found := os.waitpid(-1, os.WNOHANG))[0]:
            ended = _ended(logs.pop(found[0]))
            ended.with_suffix(".part").write_text(str(os.waitstatus_to_exitcode(found[1])), "ascii")
            ended.with_suffix(".part").rename(ended)
        if not asked:
            continue
        line = sys.stdin.readline()
        if not line:
            for pid in logs:
                os.kill(pid, signal.SIGKILL)
            os._exit(0)
        arguments, environment, log = json.loads(line)
        pid = os.fork()
        if pid:
            logs[pid] = Path(log)
            os.write(replies, b"%d\n" % pid)
            continue
        os.close(replies)
        os.environ.clear()
        os.environ.update(environment)
        os.chdir(Path(log).parent)
        for path, flags, targets in ((os.devnull, os.O_RDONLY, (0,)), (log, os.O_WRONLY, (1, 2))):
            file = os.open(path, flags)
            for target in targets:
                os.dup2(file, target)
            os.close(file)
        return arguments


if __name__ == "__main__":
    _replies = os.dup(1)
    os.dup2(2, 1)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    _import_all()
    gc.collect()
    gc.freeze()  # what is here already is not searched again, by no process
    sys.argv = _serve(_replies)
    runpy.run_module(sys.argv[0], run_name="__main__", alter_sys=True)
