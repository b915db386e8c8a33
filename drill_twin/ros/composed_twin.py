# SPDX-License-Identifier: Apache-2.0
"""Several nodes in one process: simulator, rig driver and analyzer, and nodes that a flag asks for.

Each node runs its own loop in a thread; the simulator's physics runs with the GIL released. Names and topics are the
same as of separate nodes, so other nodes can observe, command and record the twin.
"""

from __future__ import annotations

import importlib
import threading
from collections.abc import Callable, Iterable, Sequence
from types import SimpleNamespace

from rclpy.context import Context
from rclpy.node import Node

from drill_twin.core.companions import COMPANIONS
from drill_twin.ros.core.given import given_parameters, warn_of_misspelled
from drill_twin.ros.core.node import TwinNode
from drill_twin.ros.core.node_main import init_context, print_help, run_in_order
from drill_twin.ros.core.parameters import Parameter, declare
from drill_twin.ros.core.stop_request import StopRequest
from drill_twin.ros.deployment import readable_refusal
from drill_twin.ros.entry_points import load, parameter_names

_OF_COMPANIONS = tuple(
    (flag, node, companion.name)
    for companion in COMPANIONS
    for node, flag in companion.nodes.items()
    if node not in companion.programs
)
"""Flag, name and package of each node of a companion."""
NAME, PURPOSE = "twin", "Nodes in one process, with a flag for each; a parameter reaches all that have it."
PARAMETERS = (
    Parameter("drive", True, "whether to run the rig driver"),
    Parameter("analyze", True, "whether to run the analyzer"),
    Parameter("record", False, "whether to record a bag"),
    *(
        Parameter(flag, False, f"whether to run the {node} (of {package}); its parameters then stand here too")
        for flag, node, package in _OF_COMPANIONS
    ),
)
_ALWAYS_KNOWN = ("simulator", "rig_driver", "analyzer", "recorder")
"""Nodes whose parameters the process takes whether they run or not."""
_FLAGS = {"analyze": "analyzer", "record": "recorder"} | {flag: node for flag, node, _ in _OF_COMPANIONS}
"""Nodes by their flag, without the rig driver, which comes after them."""
_WAITED_FOR = ("analyzer", "recorder")
"""Nodes that must miss no message."""
Kind = Callable[[Context, Iterable[str]], TwinNode]
"""Class of a node, or a function that makes one, from a context and the names of the parameters of other nodes."""


class NodeThread:
    """Runs a node in a thread of its own."""

    def __init__(self, node: TwinNode, all_stop: StopRequest, errors: list[BaseException]) -> None:
        """Start the thread; an error of the node is appended to `errors`, and asks all nodes to stop."""
        self._stop = StopRequest()

        def run() -> None:
            try:
                run_in_order(node, self._stop)
            except BaseException as error:  # noqa: BLE001 - raised by the main thread
                errors.append(error)
                all_stop.set()

        self._thread = threading.Thread(target=run, name=node.NAME)
        self._thread.start()

    def end(self) -> None:
        """Request the node to stop, and wait until it has."""
        self._stop.set()
        self._thread.join()


def _flags(context: Context) -> SimpleNamespace:
    """Flags among the parameters given; the nodes judge the other ones."""
    node = Node(NAME, context=context)
    try:
        return declare(node, PARAMETERS, other_names=given_parameters(node))[0]
    finally:
        node.destroy_node()


def _table(kinds: Iterable[type[TwinNode]]) -> dict[str, Parameter]:
    rows = (*PARAMETERS, *(parameter for kind in kinds for parameter in kind.PARAMETERS))
    return {parameter.name: parameter for parameter in rows}


def run(arguments: Sequence[str], stop: StopRequest, *observers: Kind) -> None:
    """Run the nodes until the simulator is done or one fails, and nodes that observe them.

    Raises:
        DrillTwinError: A node refused to start or could not go on.
    """
    kinds = {name: load(name) for name in _ALWAYS_KNOWN}
    if print_help(NAME, PURPOSE, tuple(_table(kinds.values()).values()), arguments):
        return
    context = init_context(arguments, stop)
    threads: list[NodeThread] = []
    errors: list[BaseException] = []  # the first is the cause; the other nodes were stopped because of it
    try:
        with stop.at_once(), readable_refusal():
            flags = _flags(context)
            wanted = [name for flag, name in _FLAGS.items() if getattr(flags, flag)]
            kinds |= {name: load(name) for name in wanted}
            table = _table(kinds.values())
            nodes: list[TwinNode] = [kinds[name](context, table) for name in wanted]
            if flags.drive:
                waited = ("simulator", *(name for name in wanted if name in _WAITED_FOR))
                nodes.insert(0, kinds["rig_driver"](context, table, wait_for=waited))
            nodes += [observer(context, table) for observer in observers]
            simulator = kinds["simulator"](context, table)
            warn_of_misspelled(simulator, simulator.unknown, parameter_names())
            # Imported while there is one thread: a signal during an import would leave the others a partial module.
            for module in ("drill_twin.dynamics.twin.twin", "drill_twin.io.whirl_pipeline"):
                importlib.import_module(module)
        # Ended in this order: subscribers after publishers.
        threads = [NodeThread(node, stop, errors) for node in nodes]
        run_in_order(simulator, stop)
    except BaseException as error:  # noqa: BLE001 - raised below
        errors.append(error)
    finally:
        for thread in threads:
            thread.end()
        context.try_shutdown()
    if errors:
        raise errors[0]
