# SPDX-License-Identifier: Apache-2.0
"""Several nodes in one process: simulator, rig driver and analyzer, and nodes that a flag asks for.

Each node runs its own loop in a thread; the simulator's physics runs with the GIL released. Names and topics are the
same as of separate nodes, so other nodes can observe, command and record the twin.
"""

import importlib
import threading
from collections.abc import Callable, Iterable, Sequence
from types import SimpleNamespace

from rclpy.context import Context
from rclpy.node import Node

from drill_twin.ros.core.given import given_parameters, warn_of_misspelled
from drill_twin.ros.core.node import TwinNode
from drill_twin.ros.core.node_main import init_context, print_help, run_in_order
from drill_twin.ros.core.parameters import Parameter, declare
from drill_twin.ros.core.stop_request import StopRequest
from drill_twin.ros.deployment import readable_refusal
from drill_twin.ros.entry_points import PACKAGE, SIMULATOR, TWIN, load, parameter_names, waits

_BESIDE = {name: row for name, row in TWIN.items() if name != SIMULATOR and row.has_parameters}
"""Nodes beside the simulator that this process can run."""
NAME, PURPOSE = "twin", "Nodes in one process, with a flag for each; a parameter reaches all that have it."
PARAMETERS = tuple(
    Parameter(
        row.flag,
        row.runs,
        f"whether to run the {name.replace('_', ' ')}"
        + f" (of {row.package}); its parameters then stand here too" * (row.package != PACKAGE),
    )
    for name, row in _BESIDE.items()
)
_ALWAYS_KNOWN = tuple(name for name, row in TWIN.items() if row.package == PACKAGE)
"""Nodes whose parameters the process takes whether they run or not."""
Kind = Callable[[Context, Iterable[str]], TwinNode]
"""Class of a node, or a function that makes one, from a context and the names of the parameters of other nodes."""


def _run_beside(node: TwinNode, all_stop: StopRequest, errors: list[BaseException]) -> Callable[[], None]:
    """Run a node in a thread of its own; returns a function that asks the node to end, and waits until it has.

    An error of the node is appended to `errors`, and asks all nodes to stop.
    """
    stop = StopRequest()

    def run() -> None:
        try:
            run_in_order(node, stop)
        except BaseException as error:  # noqa: BLE001 - raised by the main thread
            errors.append(error)
            all_stop.set()

    def end() -> None:
        stop.set()
        thread.join()

    thread = threading.Thread(target=run, name=node.NAME)
    thread.start()
    return end


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
    ends: list[Callable[[], None]] = []
    errors: list[BaseException] = []  # the first is the cause; the other nodes were stopped because of it
    try:
        with stop.at_once(), readable_refusal():
            flags = _flags(context)
            wanted = [name for name, row in _BESIDE.items() if getattr(flags, row.flag)]
            kinds |= {name: load(name) for name in wanted}
            table = _table(kinds.values())
            running = {SIMULATOR, *wanted}
            nodes: list[TwinNode] = [kinds[name](context, table, **waits(name, running)) for name in wanted]
            nodes += [observer(context, table) for observer in observers]
            simulator = kinds[SIMULATOR](context, table)
            warn_of_misspelled(simulator, simulator.unknown, parameter_names())
            # Imported while there is one thread: a signal during an import would leave the others a partial module.
            for module in ("drill_twin.dynamics.twin.twin", "drill_twin.io.whirl_pipeline"):
                importlib.import_module(module)
        # Ended in this order: subscribers after publishers.
        ends = [_run_beside(node, stop, errors) for node in nodes]
        run_in_order(simulator, stop)
    except BaseException as error:  # noqa: BLE001 - raised below
        errors.append(error)
    finally:
        for end in ends:
            end()
        context.try_shutdown()
    if errors:
        raise errors[0]
