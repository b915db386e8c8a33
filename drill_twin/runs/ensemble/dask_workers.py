# SPDX-License-Identifier: Apache-2.0
"""Members of an ensemble on many machines: batches of them are tasks of a Dask cluster (docs/ensembles.md).

A task is a function of its arguments alone, so that the scheduler gives the tasks of a lost worker to another. A few
tasks for each core are on their way at a time: scheduler and client do not grow with the number of members.
"""

import logging
import pickle
import platform
from collections.abc import Generator, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from functools import cache
from itertools import islice
from queue import Empty, SimpleQueue
from threading import Lock
from typing import Any

import llvmlite
import numba
import numpy as np

from drill_twin.core import __version__
from drill_twin.core.compile.source_hash import source_hash
from drill_twin.core.errors import DrillTwinError, RunError, import_extra
from drill_twin.dynamics.solver.kernel_codegen import packages_of, source
from drill_twin.dynamics.twin.dynamics import kernel_of
from drill_twin.physics.effects import Effect
from drill_twin.runs.compilation import compile_kernel
from drill_twin.runs.ensemble.members import Member, Members, scene_of
from drill_twin.runs.ensemble.outputs import Request
from drill_twin.runs.ensemble.run import MemberRun, run_member
from drill_twin.scene import Scene

CONNECT = 10.0
"""Time in which a scheduler must answer [s]."""
PATIENCE = 60.0
"""Time without any worker after which a run is given up [s]."""
TASKS_PER_CORE = 4
"""Tasks that are on their way for each core of the workers."""
LARGEST_TASK = 64
"""Largest number of members of a task."""

_POLL = 5.0  # s between two looks at a cluster from which nothing comes
_PREPARE = Lock()
_PREPARED: set[tuple[Any, ...]] = set()


class DaskWorkers(AbstractContextManager["DaskWorkers"]):
    """Workers of a Dask scheduler, as a place where members are run (`drill_twin.runs.ensemble.run.Executor`)."""

    def __init__(self, address: str) -> None:
        """Connect.

        Args:
            address: Address of the scheduler, `tcp://host:8786`.

        Raises:
            ArgumentError: distributed is not installed.
            RunError: No scheduler answers, or it has no workers.
        """
        self.address = address
        self._distributed = import_extra("distributed")
        logging.getLogger("distributed.client").setLevel(logging.CRITICAL)  # its errors are raised here
        try:
            self._distributed.comm.resolve_address(address)  # a client of an invalid address would not end
            self._client = self._distributed.Client(address, timeout=CONNECT, set_as_default=False)
        except (OSError, ValueError, TypeError) as error:
            raise RunError(
                f"{address}: expected a Dask scheduler, found none ({type(error).__name__}: {error}); "
                "start one with `dask scheduler`, and give the address that it prints"
            ) from error
        try:
            self._client.wait_for_workers(1, timeout=CONNECT)
        except TimeoutError as error:
            self.close()
            raise self._without_workers(CONNECT) from error

    def run(self, members: Members, request: Request) -> Generator[tuple[int, MemberRun]]:
        """As in `Executor`."""
        threads: Mapping[str, int] = self._client.nthreads()  # of all workers at present
        cores, setup, sources = (
            max(1, sum(threads.values())),
            pickle.dumps((members.base, request)),
            fingerprint(members.base),
        )
        size = min(LARGEST_TASK, max(1, len(members) // (TASKS_PER_CORE * cores)))
        tasks, ended = _tasks(iter(members), size), SimpleQueue[Any]()
        waiting: dict[Any, Sequence[Member]] = {}
        try:
            while True:
                for task in islice(tasks, TASKS_PER_CORE * cores - len(waiting)):
                    future = self._client.submit(run_task, setup, sources, pickle.dumps(task), pure=False)
                    waiting[future] = task
                    future.add_done_callback(ended.put)
                if not waiting:
                    return
                future = self._next(ended)
                found = self._result(future)
                yield from zip((member.number for member in waiting.pop(future)), found, strict=True)
        finally:
            self._client.cancel(list(waiting))

    def _next(self, ended: SimpleQueue[Any]) -> Any:
        """The next task that has ended."""
        silent = 0.0
        while True:
            try:
                return ended.get(timeout=_POLL)
            except Empty:
                silent = silent + _POLL if not self._client.nthreads() else 0.0
            if silent >= PATIENCE:
                raise self._without_workers(silent)

    def _result(self, future: Any) -> list[MemberRun]:
        try:
            found: list[MemberRun] = future.result()
        except DrillTwinError as error:
            raise RunError(f"{self.address}: {error}") from error
        except self._distributed.scheduler.KilledWorker as error:
            raise RunError(
                f"{self.address}: expected workers that outlive their members, found that "
                f"{error.allowed_failures + 1} died in the same members, the last at {error.last_worker.address}; "
                "see their logs, and give them more memory"
            ) from error
        except self._distributed.client.FutureCancelledError as error:
            raise RunError(
                f"{self.address}: expected a Dask scheduler to the end, found its connection lost; "
                "start it and its workers again, and repeat the command"
            ) from error
        except Exception as error:
            raise RunError(
                f"{self.address}: expected runs of the workers, found {type(error).__name__}: {error}; "
                "install this drill_twin for scheduler and workers"
            ) from error
        return found

    def _without_workers(self, seconds: float) -> RunError:
        return RunError(
            f"{self.address}: expected workers of the Dask scheduler, found none for {seconds:.0f} s; "
            f"start some with `dask worker {self.address}`"
        )

    def close(self) -> None:
        """End the connection; scheduler and workers stay."""
        self._client.close()

    def __exit__(self, *_: object) -> None:
        self.close()


def _tasks(members: Iterator[Member], size: int) -> Iterator[list[Member]]:
    while task := list(islice(members, size)):
        yield task


# --- in the worker --------------------------------------------------------------------------------------------------


def run_task(setup: bytes, expected: Mapping[str, str], members: bytes) -> list[MemberRun]:
    """Run members of a scene; called in a worker.

    Args:
        setup: Pickled base scene and outputs; bytes, which the scheduler passes on as they are.
        expected: `fingerprint` of the client.
        members: The members, pickled.

    Raises:
        RunError: This worker would not compute what the client would.
    """
    try:
        base, request = pickle.loads(setup)  # noqa: S301 - from the client, as the function itself
        found = fingerprint(base)
    except Exception as error:
        raise RunError(
            f"worker on {platform.node()}: expected to know the effects of the scene, "
            f"found {type(error).__name__}: {error}; install what the client has"
        ) from error
    if other := [name for name, value in expected.items() if found.get(name) != value]:
        differences = " and ".join(f"{name} {expected[name]}" for name in other)
        here = " and ".join(found.get(name, "none") for name in other)
        raise RunError(
            f"worker on {platform.node()}: expected {differences} as the client, found {here}; "
            "install the same versions on all machines and start the workers again"
        )
    task: Sequence[Member] = pickle.loads(members)  # noqa: S301
    first = scene_of(base, task[0])
    analysis, kernel = "findings" in request.names, kernel_of(first)
    with _PREPARE:
        if (kernel, analysis) not in _PREPARED:
            compile_kernel(first, request.period, lambda _: None, analysis=analysis)  # in a child: a worker must answer
            _PREPARED.add((kernel, analysis))
    return [run_member(base, request, member) for member in task]


def fingerprint(scene: Scene) -> dict[str, str]:
    """Versions and source on which the bits of a run depend, besides the processor."""
    return {
        "drill_twin": __version__, "Python": platform.python_version(), "numpy": np.__version__,
        "numba": numba.__version__, "llvmlite": llvmlite.__version__, "source of the runs": _source(kernel_of(scene)),
    }  # fmt: skip


@cache
def _source(kernel: tuple[tuple[Effect, ...], str, str, bool]) -> str:
    effects, form, _, audit = kernel
    text = f"{source(effects, form, audit=audit)}\nimport drill_twin.runs.ensemble.run\n"
    return source_hash(text, packages_of(effects))[:12]
