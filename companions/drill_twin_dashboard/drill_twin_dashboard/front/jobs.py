# SPDX-License-Identifier: Apache-2.0
"""Commands of the page as processes: two at a time; what they print is kept as it comes."""

import os
import shlex
import subprocess
import sys
import threading
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from drill_twin.core.errors import RunError

AT_ONCE = 2
"""Commands that run at a time, pages of their own (`drill-twin watch`) not counted. Chosen, not measured."""
MOST = 8
"""Commands whose output is kept. Chosen, not measured."""
KEPT = 20_000
"""Characters of output that are kept of a command, its last. Chosen, not measured."""
PATIENCE = 5.0
"""Time for a command to end after all were asked to, when the page ends [s]. Chosen, not measured."""


class Jobs:
    """The commands of a page; one thread calls its functions."""

    def __init__(self, folder: Path) -> None:
        """Without a command yet.

        Args:
            folder: Folder in which the commands run.
        """
        self._folder, self._running = folder, dict[int, subprocess.Popen[str]]()
        self.shown = list[dict[str, Any]]()
        """Number, words, result, output and exit code (null while it runs) of each command, the newest first."""

    def add(self, words: Sequence[str], out: str) -> None:
        """Start a command.

        Args:
            words: Its words, without `drill-twin`.
            out: Folder or file that it makes.

        Raises:
            RunError: Too many run, or no process can be started.
        """
        page = words[0] == "watch"
        if not page and sum(job["code"] is None and not job["page"] for job in self.shown) >= AT_ONCE:
            raise RunError(f"expected at most {AT_ONCE} commands at a time, found more; stop a command, or wait")
        try:
            process = subprocess.Popen(
                [sys.executable, "-uP", "-m", "drill_twin.cli", *words],  # P: no module of the folder is imported
                cwd=self._folder, env={**os.environ, "COLUMNS": "100"}, stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE, stderr=subprocess.STDOUT, encoding="utf-8", errors="replace",
                start_new_session=True,  # Ctrl-C in the terminal reaches the page alone
            )  # fmt: skip
        except (OSError, ValueError) as error:  # no memory; a null character
            raise RunError(
                f"expected to start drill-twin {words[0]}, found: {error}; free memory, or correct the options"
            ) from error
        job = {"number": process.pid, "line": shlex.join(["drill-twin", *words]), "out": out, "page": page}
        job |= {"text": "", "code": None}
        self.shown = [job, *(old for at, old in enumerate(self.shown) if at < MOST - 1 or old["code"] is None)]
        self._running[process.pid] = process
        threading.Thread(target=self._follow, args=(job, process), daemon=True).start()

    def stop(self, number: int) -> None:
        """Ask a command to end as by Ctrl-C: a run keeps its bag. Asked again, it ends at once.

        The signal is SIGTERM, which commands take as they take SIGINT: a shell without a terminal lets its jobs, and
        their children, ignore SIGINT.
        """
        if process := self._running.get(number):
            process.terminate()

    def close(self) -> None:
        """Stop all commands, and kill what does not end."""
        running = list(self._running.values())
        for process in running:
            process.terminate()
        for process in running:
            try:
                process.wait(PATIENCE)
            except subprocess.TimeoutExpired:
                process.kill()

    def _follow(self, job: dict[str, Any], process: subprocess.Popen[str]) -> None:
        for line in process.stdout or ():
            job["text"] = (job["text"] + line)[-KEPT:]
        job["code"] = process.wait()
        del self._running[job["number"]]
