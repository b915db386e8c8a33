# SPDX-License-Identifier: Apache-2.0
"""Entry points of the nodes: signals first, then the imports, then the node; one line and an exit code for an error.

`TWIN` and `REPLAY` are the nodes that are started together, by which the launch files, the process of all nodes and the
demo go. This module needs the standard library alone: `ros2 launch` may run in another Python environment.

Exit codes: 0 ended as asked (also by SIGINT or SIGTERM), 1 the run could not go on, 2 refused to start.

A new node is a class of `core.node.TwinNode`, a row in `NODES` (in another package: an entry point of `GROUP`), its
parameter file `config/nodes/NAME.yaml`, which `drill-twin ros node NAME --parameters` prints, and its executable, a
link to another one in `resource/executables/`. Help text, security policy and tests of the node follow from its class.
"""

import importlib
import sys
from collections.abc import Collection, Iterator, Sequence
from contextlib import suppress
from importlib.util import find_spec
from typing import Any, NamedTuple, NoReturn

from drill_twin.core.companions import COMPANIONS, entries, entry_of, not_installed
from drill_twin.core.errors import DrillTwinError, RunError, printable
from drill_twin.core.process import (
    end_process,
    error_text,
    open_closed_streams,
    refuse_too_little_memory,
    use_one_thread_of_blas,
)
from drill_twin.ros.core.stop_request import Stopped, StopRequest

NODES = {
    "simulator": "drill_twin.ros.simulator.node:Simulator",
    "rig_driver": "drill_twin.ros.rig_driver.node:RigDriver",
    "analyzer": "drill_twin.ros.analyzer:Analyzer",
    "recorder": "drill_twin.ros.bag.recorder:Recorder",
    "replayer": "drill_twin.ros.bag.replayer:Replayer",
}
"""Module and class of each node of the core."""
PROGRAMS = {
    "twin": "drill_twin.ros.composed_twin:run",
    "demo": "drill_twin.ros.demo:run",
}
"""Module and function of a program that starts several nodes, or takes other arguments than ROS's."""
GROUP = "drill_twin.nodes"
"""Entry-point group of nodes in other packages: a class of `TwinNode`, or a function as in `PROGRAMS`."""
PACKAGE = "drill_twin"


class Row(NamedTuple):
    """A node among others."""

    flag: str
    """Launch argument, and parameter of the process of all nodes, that asks for the node; empty: it always runs."""
    runs: bool
    """Default of the flag."""
    takes: str
    """Parameters that launch arguments of the same names set, separated by spaces."""
    package: str = PACKAGE
    has_parameters: bool = True
    """False for a program, which has none."""


SIMULATOR, RIG_DRIVER, ANALYZER, RECORDER, REPLAYER = "simulator", "rig_driver", "analyzer", "recorder", "replayer"
_TAKES = {"advisor": "map", "estimator": "scene free"}
TWIN = {
    SIMULATOR: Row("simulate", True, "scene overrides accuracy pace duration checkpoint frame_prefix"),
    RIG_DRIVER: Row("drive", True, "scene overrides table wob rpm"),
    ANALYZER: Row("analyze", True, ""),
    RECORDER: Row("record", False, "bag"),
    **{
        node: Row(flag, False, _TAKES.get(node, ""), companion.name, node not in companion.programs)
        for companion in COMPANIONS
        for node, flag in companion.nodes.items()
    },
}
"""Nodes of a twin by name."""
REPLAY = {REPLAYER: Row("", True, "bag rate map loop twin"), ANALYZER: TWIN[ANALYZER]}
"""Nodes of a replay by name."""
_SENDS_FIRST = (RIG_DRIVER, REPLAYER)
_MISSES_NOTHING = (SIMULATOR, ANALYZER, RECORDER)


def waits(node: str, running: Collection[str]) -> dict[str, tuple[str, ...]]:
    """Parameter of a node that sends first: the running nodes that must miss no message; no parameter of other nodes.

    Args:
        node: Name of the node.
        running: Names of the nodes that run beside it, here or elsewhere.
    """
    return {"wait_for": tuple(name for name in _MISSES_NOTHING if name in running)} if node in _SENDS_FIRST else {}


def executables() -> tuple[str, ...]:
    """Names of all nodes and programs, also of companions that are not installed."""
    return tuple(dict.fromkeys((*NODES, *TWIN, *(entry.name for entry in entries(GROUP)), *PROGRAMS)))


def node_names() -> tuple[str, ...]:
    """Names of the nodes that are installed, also in other packages; without programs."""
    programs = frozenset().union(*(companion.programs for companion in COMPANIONS))
    return (*NODES, *(entry.name for entry in entries(GROUP) if entry.name not in programs))


def parameter_names() -> Iterator[str]:
    """Names of the parameters of all nodes that can be imported, of the core's nodes first."""
    for name in node_names():
        with suppress(DrillTwinError):
            yield from (parameter.name for parameter in load(name).PARAMETERS)


def load(name: str) -> Any:
    """Import the class of a node, or the function of a program.

    Raises:
        DrillTwinError: There is none of that name, or a package it needs is not installed.
    """
    if name not in (known := executables()):
        raise DrillTwinError(f"expected one of {', '.join(known)}, found {name!r}")
    place = {**NODES, **PROGRAMS}.get(name) or getattr(entry_of(GROUP, name), "value", "")
    if not place:
        raise not_installed(f"the node {name}", TWIN[name].package)
    module, _, attribute = place.partition(":")
    try:
        if find_spec("rclpy") is None:  # a program may import it late
            raise ModuleNotFoundError(name="rclpy")
        return getattr(importlib.import_module(module), attribute)
    except ModuleNotFoundError as error:
        raise _missing(error) from error


def start(name: str, arguments: Sequence[str] | None = None) -> int:
    """Run a node or a program of this package until it ends or is asked to; returns the exit code."""
    stop = StopRequest()
    stop.install()
    open_closed_streams()
    use_one_thread_of_blas()
    given = list(sys.argv[1:] if arguments is None else arguments)
    try:
        refuse_too_little_memory()
        with stop.at_once():
            target = load(name)
        if isinstance(target, type):
            from drill_twin.ros.core.node_main import run_node

            run_node(target, given, stop, parameter_names())
        else:
            target(given, stop)
    except Stopped:
        if name != "demo":  # a node that was asked to end has done so; a demo without a run has not succeeded
            return 0
        print("demo: error: stopped before it began; nothing was recorded", file=sys.stderr, flush=True)
        return 1
    except DrillTwinError as error:
        print(f"{name}: error: {error}", file=sys.stderr, flush=True)
        return 1 if isinstance(error, RunError) else 2
    except (OSError, MemoryError) as error:
        print(f"{name}: error: {printable(error_text(error))}", file=sys.stderr, flush=True)
        return 1
    return 0


def end(code: int) -> NoReturn:
    """End the process with an exit code, which no later signal changes."""
    StopRequest.ignore_signals()
    end_process(code)


def _missing(error: ModuleNotFoundError) -> DrillTwinError:
    remedy = "source /opt/ros/jazzy/setup.bash, or pip install 'drill_twin[ros]' (in a clone: make setup)"
    if error.name and not error.name.startswith(("rclpy", "rcl_", "std_", "sensor_", "geometry_", "diagnostic_")):
        remedy = "run `make setup`, or pip install the requirements of drill_twin into this Python"
    return DrillTwinError(f"expected the Python module {error.name!r}, found none in {sys.prefix}; {remedy}")
