# SPDX-License-Identifier: Apache-2.0
"""Hooks of all tests, those of the core, of the companions and of the evidence: faults, and workers that die."""

import os
import subprocess
import sys
from contextlib import suppress

import pytest


def pytest_configure(config: pytest.Config) -> None:
    """A test of a fault says which it is and what is survived; `make faults` prints them as a table."""
    config.addinivalue_line("markers", "fault(what, then): a fault that is survived, for the table of `make faults`")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Take what a fault's marker says along to the report."""
    for item in items:
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
