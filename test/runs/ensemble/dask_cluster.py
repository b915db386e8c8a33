# SPDX-License-Identifier: Apache-2.0
"""A Dask scheduler and workers, each a process of its own; all of their ports are of this machine alone."""

import os
import subprocess
import sys
import time
from contextlib import ExitStack, contextmanager
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]


class Cluster:
    """Processes of a cluster; `address` is the scheduler's."""

    def __init__(self, folder, stack, protocol="tcp", **environment):
        self._folder, self._stack, self._environment, self._protocol = folder, stack, environment, protocol
        file = folder / "address"
        self.scheduler = self._start("scheduler", "--port", "0", "--scheduler-file", file)
        for _ in range(600):
            if file.exists() and (text := file.read_text("utf-8")).endswith("}"):
                break
            time.sleep(0.1)
        self.address = text.partition('"address": "')[2].partition('"')[0]

    def worker(self, tree=ROOT):
        """Start a worker with one thread, which imports the package from a tree."""
        return self._start("worker", self.address, "--nthreads", "1", "--no-nanny", tree=tree)

    def _start(self, kind, *words, tree=ROOT):
        here = ["--host", "127.0.0.1", "--no-dashboard", "--dashboard-address", "127.0.0.1:0"]
        here += ["--protocol", self._protocol]
        process = subprocess.Popen(
            [sys.executable, "-m", f"distributed.cli.dask_{kind}", *map(str, words), *here],
            env=os.environ | {"PYTHONPATH": str(tree), "PYTHONSAFEPATH": "1"} | self._environment,
            cwd=self._folder,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        self._stack.callback(process.wait)
        self._stack.callback(process.kill)
        return process


@contextmanager
def cluster(folder, *given, **environment):
    """A scheduler without workers, until the end of the block."""
    with ExitStack() as stack:
        yield Cluster(folder, stack, *given, **environment)
