# SPDX-License-Identifier: Apache-2.0
"""Simulator, rig driver, analyzer and, with `record`, recorder in one process.

Each node runs its own loop in a thread; the simulator's physics runs with the GIL released. Topics are those of the
separate nodes, so other nodes can observe, command and record the twin.
"""

from __future__ import annotations

import importlib
import math
import threading
import time
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import ClassVar

from drill_twin.ros.analyzer.node import Analyzer
from drill_twin.ros.bag.recorder import Recorder
from drill_twin.ros.core.node import TwinNode
from drill_twin.ros.core.node_main import init_context, print_help, run_in_order
from drill_twin.ros.core.parameters import Parameter, Value
from drill_twin.ros.core.stop_request import StopRequest
from drill_twin.ros.deployment.security import readable_refusal
from drill_twin.ros.rig_driver.node import RigDriver
from drill_twin.ros.simulator.node import Simulator


class ComposedTwin(TwinNode):
    """Parameter `record`; the help text of the process names the parameters of all nodes."""

    NAME: ClassVar = "twin"
    PURPOSE: ClassVar = (
        "Simulator, rig driver, analyzer and recorder in one process; a parameter reaches all that have it."
    )
    PARAMETERS: ClassVar = (Parameter("record", False, "whether to record a bag"),)


_NODES: tuple[type[TwinNode], ...] = (Simulator, RigDriver, Analyzer, Recorder)


class NodeThread:
    """Runs a node in a thread of its own."""

    def __init__(self, node: TwinNode, failed: StopRequest) -> None:
        self.error: BaseException | None = None
        self.failed_at = math.inf
        """Wall time of the error [s]; infinite without one."""
        self._node, self._failed, self._stop = node, failed, StopRequest()
        self._thread = threading.Thread(target=self._run, name=node.NAME)
        self._thread.start()

    def _run(self) -> None:
        try:
            run_in_order(self._node, self._stop)
        except BaseException as error:  # noqa: BLE001 - handed to the main thread by `end`
            self.error, self.failed_at = error, time.monotonic()
            self._failed.set()

    def end(self) -> None:
        """Request the node to stop, and wait until it has."""
        self._stop.set()
        self._thread.join()


def _sharing(kind: type[TwinNode], names: Iterable[str], **defaults: Value) -> type[TwinNode]:
    """Kind of node that accepts parameters of others in its process; `defaults` are in place of those of its table."""
    rows = tuple(replace(row, default=defaults.get(row.name, row.default)) for row in kind.PARAMETERS)
    return type(kind.__name__, (kind,), {"PARAMETERS": rows, "OTHER_PARAMETERS": frozenset(names)})


def run(arguments: Sequence[str], stop: StopRequest) -> None:
    """Run all nodes until the simulator is done or one fails."""
    kinds: tuple[type[TwinNode], ...] = (ComposedTwin, *_NODES)
    table = {parameter.name: parameter for kind in kinds for parameter in kind.PARAMETERS}
    if print_help(ComposedTwin.NAME, ComposedTwin.PURPOSE, tuple(table.values()), arguments):
        return
    context = init_context(arguments, stop)
    threads: list[NodeThread] = []
    failed_at = math.inf
    try:
        with stop.at_once(), readable_refusal():
            record = _sharing(ComposedTwin, table)(context)
            others = [Analyzer, *([Recorder] if record.settings.record else [])]
            record.destroy_node()
            nodes = [_sharing(kind, table)(context) for kind in others]
            waited = " ".join(["simulator", *(node.NAME for node in nodes)])
            driver = _sharing(RigDriver, table, wait_for=waited)(context)
            simulator = _sharing(Simulator, table)(context)
            # Imported while there is one thread: a signal during an import would leave the others a partial module.
            for module in ("drill_twin.dynamics.twin.twin", "drill_twin.io.whirl_pipeline"):
                importlib.import_module(module)
        # Ended in this order: subscribers after publishers.
        threads = [NodeThread(node, stop) for node in (driver, *nodes)]
        run_in_order(simulator, stop)
    except BaseException:
        failed_at = time.monotonic()
        raise
    finally:
        for thread in threads:
            thread.end()
        context.try_shutdown()
        # The first error is the cause; the others were stopped because of it.
        first = min(threads, key=lambda thread: thread.failed_at, default=None)
        if first is not None and first.error is not None and first.failed_at < failed_at:
            raise first.error
