# SPDX-License-Identifier: Apache-2.0
"""A stop that comes at any line of a node's configuration: the node closes in order, with whatever it has by then."""

import sys
from contextlib import suppress

import pytest

from drill_twin.ros.core.node_main import init_context
from drill_twin.ros.core.stop_request import Stopped, StopRequest
from drill_twin.ros.entry_points import load, node_names

STEPS = {"simulator": 6, "gateway": 8, "estimator": 3}
"""Lines from one stop to the next, of the nodes whose configuration takes seconds."""


class StopAtLine:
    """Context that raises Stopped at one line of a function, counted from its first that runs."""

    def __init__(self, function, line):
        self._code, self._left, self.came = function.__code__, line, False

    def _trace(self, frame, event, _):
        if frame.f_code is not self._code:
            return None
        if event == "line":
            self._left -= 1
            if self._left < 0 and not self.came:
                self.came = True
                raise Stopped
        return self._trace

    def __enter__(self):
        self._before = sys.gettrace()
        sys.settrace(self._trace)
        return self

    def __exit__(self, *_):
        sys.settrace(self._before)


@pytest.mark.long
@pytest.mark.parametrize("name", node_names())
def test_a_stop_at_any_line_of_the_configuration_closes_the_node(bench, monkeypatch, small_bag, tmp_path, name):
    monkeypatch.setenv("ROS_DOMAIN_ID", bench.environment["ROS_DOMAIN_ID"])
    monkeypatch.setenv("ROS_LOG_DIR", str(tmp_path))
    monkeypatch.chdir(tmp_path)
    kind, given = load(name), {"replayer": ["bag", str(small_bag)]}.get(name, [])
    arguments = ["--ros-args", "-p", ":=".join(given)] if given else []
    for line in range(0, 100, STEPS.get(name, 1)):
        context = init_context(arguments, StopRequest())
        try:
            node = kind(context)
            with suppress(Stopped), StopAtLine(kind.configure, line) as stopped:
                node.start()
            node.close()
        finally:
            context.try_shutdown()
        if not stopped.came:
            break
    assert line > 3
