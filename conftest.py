# SPDX-License-Identifier: Apache-2.0
"""Hooks of all tests, those of the core, of the companions and of the evidence: faults, and workers that die."""

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import suppress
from functools import cache
from pathlib import Path
from types import FunctionType
from typing import Any

import pytest


def pytest_configure(config: pytest.Config) -> None:
    """A test of a fault says which it is and what is survived; `make faults` prints them as a table."""
    config.addinivalue_line("markers", "fault(what, then): a fault that is survived, for the table of `make faults`")


ROOT = Path(__file__).parent
MARKED_BY = {
    "process": {"subprocess", "Popen", "fork", "Process", "rclpy", "process_bench", "attack", "harmless", "Browser"},
    "compiles": {
        "Session", "SessionRun", "Simulation", "Twin", "Dynamics", "compile_kernel", "build_kernel", "run_command",
        "Analyzer", "BitOnlyAnalyzer", "WhirlPipeline", "read_recording", "summarise", "build_report", "Ensemble",
        "entry_kernel", "load_generated", "njit", "linearise", "steady_whirl", "equilibrium", "run_many", "read_bag",
    },
}  # fmt: skip
"""Marker -> names by which code of a test, or of what it calls in the test house, starts processes or compiles."""


@cache
def _is_of_tests(file: str) -> bool:
    return Path(file).is_relative_to(ROOT) and "test" in Path(file).relative_to(ROOT).parts


@cache
def _all_names(function: Any) -> frozenset[str]:
    """Names of `_names`, found once for a test of many variants and for a fixture of many tests."""
    return frozenset(_names(function, set()))


def _names(function: Any, seen: set[Any]) -> Iterator[str]:
    """Names in the code of a function, and in that of the functions and classes of the test house which it names."""
    function = getattr(function, "__wrapped__", function)
    file = getattr(sys.modules.get(getattr(function, "__module__", "")), "__file__", None) or ""
    if function in seen or not _is_of_tests(file):
        return
    seen.add(function)
    if isinstance(function, type):
        for method in vars(function).values():
            if isinstance(method, FunctionType):
                yield from _names(method, seen)
    codes = [function.__code__] if isinstance(function, FunctionType) else []
    while codes:
        code = codes.pop()
        codes += [constant for constant in code.co_consts if isinstance(constant, type(code))]
        for name in code.co_names:
            yield name
            if isinstance(found := function.__globals__.get(name), FunctionType | type):
                yield from _names(found, seen)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark tests that start a process or compile, and take what a fault's marker says along to the report."""
    for item in items:
        fixtures = getattr(item, "_fixtureinfo").name2fixturedefs.values()  # noqa: B009
        functions = [getattr(item, "function"), *(fixture.func for found in fixtures for fixture in found)]  # noqa: B009
        names = frozenset().union(*map(_all_names, functions))
        for marker, known in MARKED_BY.items():
            if names & known or (marker == "process" and "ros" in item.path.parent.parts):
                item.add_marker(marker)
        for mark in item.iter_markers("fault"):
            item.user_properties.append(("fault", mark.args))


_CRASHED: set[str] = set()


@pytest.hookimpl(optionalhook=True, trylast=True)
def pytest_handlecrashitem(crashitem: str, report: pytest.TestReport) -> None:
    """Report a test whose worker died as one that is run once more, as a failed one is; with how the worker died.

    With `--dist loadfile` the tests that the worker had not finished go to another one.
    """
    node = report.node  # type: ignore[attr-defined]
    with suppress(subprocess.TimeoutExpired):
        node.gateway._io.popen.wait(10.0)
    report.longrepr = f"{report.longrepr}; exit code of the worker: {node.gateway._io.popen.poll()}"
    node.config.get_terminal_writer().line(report.longrepr)
    option = node.config.getoption
    if option("dist") == "loadfile" and option("reruns", 0) and crashitem not in _CRASHED:
        report.outcome = "rerun"  # type: ignore[assignment]
    _CRASHED.add(crashitem)


def pytest_sessionfinish() -> None:
    """End the process that has made the imports of the nodes, where there is one."""
    if "process_bench" in sys.modules:
        sys.modules["process_bench"].WARMED.close()


def pytest_terminal_summary(terminalreporter, config: pytest.Config) -> None:
    """The table of faults, where a run was about them."""
    if not os.environ.get("DRILL_TWIN_FAULTS"):
        return
    verdicts: dict[tuple[str, str], str] = {}
    for outcome, word in (("passed", "yes"), ("failed", "**no**"), ("error", "**no**")):
        for report in terminalreporter.getreports(outcome):
            if report.when == "call" or outcome == "error":
                verdicts.update({found: word for name, found in report.user_properties if name == "fault"})
    terminalreporter.write_line("")
    terminalreporter.write_line("| fault | what happens | survived |")
    terminalreporter.write_line("| --- | --- | --- |")
    for (what, then), word in verdicts.items():
        terminalreporter.write_line(f"| {what} | {then} | {word} |")
