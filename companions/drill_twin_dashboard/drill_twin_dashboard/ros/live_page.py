# SPDX-License-Identifier: Apache-2.0
"""ROS node behind the live page: feeds the page from the twin's topics, and sends the set-points of its sliders.

With a rig driver in the graph its live parameters are set; without one the single set-points are published. Pause, step
and reset are the services of the simulator.
"""

import argparse
import time
from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from contextlib import ExitStack
from functools import partial
from typing import Any

from rcl_interfaces.srv import SetParameters
from rclpy.context import Context
from rclpy.parameter import Parameter as RosParameter
from std_srvs.srv import Trigger

from drill_twin.core.errors import DrillTwinError
from drill_twin.core.units.system import SYSTEMS
from drill_twin.io.messages.diagnostics import Level, Status
from drill_twin.io.messages.encode import encode_float64
from drill_twin.io.messages.good_samples import GONE
from drill_twin.io.messages.topics import RIG_COMMAND, RPS_COMMAND, TOPICS, TWIN_SCENE, WOB_COMMAND
from drill_twin.ros.core.graph import unlisted
from drill_twin.ros.core.node import TwinNode
from drill_twin.ros.core.node_main import init_context, run_in_order
from drill_twin.ros.core.stop_request import StopRequest
from drill_twin.ros.core.topics import installed
from drill_twin.ros.deployment import readable_refusal
from drill_twin_dashboard.live.alarms import parse_limit
from drill_twin_dashboard.live.foxglove_server import FoxgloveServer
from drill_twin_dashboard.live.page_state import INPUTS, PageState
from drill_twin_dashboard.live.shown import Sources

_DEPTH = 50  # messages; the page shows fewer
_SEARCH_PERIOD = 0.5  # s; topics of subs and frames appear with a simulator
_MATCHING = 3.0
"""Most time to wait for a simulator that takes a set-point [s]; not measured."""
_CONTROLS = ("pause", "resume", "step", "reset")
_SET_POINTS = {
    "wob": ("wob", "N", WOB_COMMAND, "weight on bit"),
    "rps": ("rpm", "rev/s", RPS_COMMAND, "rotation"),
}
"""Parameter of the rig driver, unit, topic, and words of each set-point."""


class LivePage(TwinNode):
    """Feeds the page from the topics."""

    NAME = "watch"
    PURPOSE = "Shows a running twin in the browser."
    ON_CHANGE = (TWIN_SCENE,)

    def __init__(self, context: Context, viewers: FoxgloveServer | None = None) -> None:
        """Create the node.

        Args:
            context: The rclpy context.
            viewers: Server that all topics of the contract are passed on to.
        """
        super().__init__(context)
        self._viewers = viewers
        self._sources = Sources()
        self.page_state = PageState(self._sources)
        self._asked: deque[tuple[str, float]] = deque()  # set-points and controls of the run, from the server's thread
        self._pending: list[tuple[str, float, Any]] = []
        self._answers: list[Any] = []
        self._refused = ""
        self._driver = self.create_client(SetParameters, "rig_driver/set_parameters")
        self._controls = {name: self.create_client(Trigger, f"simulator/{name}") for name in _CONTROLS}

    def configure(self) -> None:
        """Create the subscriptions."""
        self.samples.expect(TWIN_SCENE)
        self.topics.subscribe_scenes(self._on_scene)
        self._followed: set[str] = set()
        self._follow(set(INPUTS) - {TWIN_SCENE} if self._viewers is None else TOPICS)
        if self._viewers is not None:
            self.every(_SEARCH_PERIOD, lambda: self._follow(unlisted(self)))

    def _follow(self, topics: Iterable[str]) -> None:
        """Subscribe to topics, and offer them to viewers."""
        for topic in filter(installed, set(topics) - self._followed):
            self._followed.add(topic)
            if self._viewers is not None:
                self._viewers.offer(topic)
            depth = 1 if TOPICS[topic].latched else _DEPTH
            self.topics.subscribe_raw(topic, partial(self._on_message, topic), depth=depth)

    def _on_scene(self, raw: bytes) -> None:
        self.samples.take(TWIN_SCENE)
        self.page_state.update(TWIN_SCENE, raw)

    def _on_message(self, topic: str, raw: bytes, info: Mapping[str, Any]) -> None:
        if self._viewers is not None:
            self._viewers.publish(topic, raw, info["received_timestamp"])
        if topic in INPUTS and topic != TWIN_SCENE:  # scenes pass a gate
            self.page_state.update(topic, raw)

    def snapshot(self) -> Mapping[str, Any]:
        """State of the page."""
        return {**self.page_state.snapshot(), "refused": self._refused}

    def on_request(self, request: Mapping[str, Any]) -> None:
        """Queue set-points and controls of the run, for `step`: called in the server's thread.

        Raises:
            DrillTwinError: The request names no set-point, control, alarm or limit.
        """
        for name, value in self.page_state.take(request).items():
            if isinstance(value, bool) != (name in _CONTROLS) or name not in {*_SET_POINTS, *_CONTROLS}:
                expected = f"{', '.join(_SET_POINTS)} with a number or {', '.join(_CONTROLS)} with true"
                raise DrillTwinError(f"expected {expected}, found {name}: {value}")
            if name in _SET_POINTS or value:
                self._asked.append((name, float(value)))

    def step(self) -> None:
        """Process messages, and send the requested set-points."""
        self.spin_once(0.02)
        asked = [self._asked.popleft() for _ in range(len(self._asked))]
        newest = {name: value for name, value in asked if name in _SET_POINTS}  # of each slider
        for name, value in newest.items():
            self._command(name, value)
        for name in (name for name, _ in asked if name in _CONTROLS):
            self._control(name)
        if self._pending or self._answers:
            self._check_answers()

    def _control(self, name: str) -> None:
        """Ask the simulator to pause, go on, step or begin again."""
        if self._controls[name].service_is_ready():
            self._answers.append(self._controls[name].call_async(Trigger.Request()))
        else:
            self._refused = f"expected a simulator to {name}, found none"

    def _command(self, name: str, value: float) -> None:
        parameter, unit, _, words = _SET_POINTS[name]
        self.page_state.note(f"set-point: {words} {value:.6g} {unit}")
        if self._driver_present():
            change = RosParameter(parameter, value=f"{value!r} {unit}").to_parameter_msg()
            answer = self._driver.call_async(SetParameters.Request(parameters=[change]))
            self._pending.append((name, value, answer))
        else:
            self._publish(name, value)

    def _check_answers(self) -> None:
        for answer in [answer for answer in self._answers if answer.done()]:
            self._answers.remove(answer)
            said = answer.result()
            self._refused = "" if said.success else said.message
            self.page_state.note(said.message)
        present = self._driver_present()
        pending, self._pending = self._pending, []
        for name, value, answer in pending:
            if answer.done():
                self._refused = next((r.reason for r in answer.result().results if not r.successful), "")
            elif present:
                self._pending.append((name, value, answer))
            else:  # the driver ended without an answer
                self._driver.remove_pending_request(answer)
                self._publish(name, value)

    def _driver_present(self) -> bool:
        return bool(self.topics.publisher_nodes(RIG_COMMAND)) and self._driver.service_is_ready()

    def _publish(self, name: str, value: float) -> None:
        """Publish a set-point; its publisher is made on its first use, as a page that only shows commands nothing."""
        topic = _SET_POINTS[name][2]
        if topic not in self.topics.publishers:
            publisher, deadline = self.topics.advertise(topic), time.monotonic() + _MATCHING
            while not publisher.get_subscription_count() and time.monotonic() < deadline:
                self.spin_once(0.02)
                if topic not in self.topics.publishers:  # withdrawn: a rig driver has come
                    self._command(name, value)
                    return
        self.topics.publish(topic, encode_float64(value))

    def health(self) -> Status:
        """Nodes that are not heard any more, or the number of messages that could not be decoded."""
        if self._driver_present():  # its plan is set instead
            for topic in {WOB_COMMAND, RPS_COMMAND} & set(self.topics.publishers):
                self.topics.withdraw(topic)
        self.page_state.check_sources()
        missing = [row["name"] for row in self._sources.nodes() if row["age"] > GONE]  # and did not end in order
        skipped = len(self.page_state.skipped)
        return self.status(
            {},
            (Level.WARN, f"no diagnostics for more than {GONE:g} s of {', '.join(missing)}" if missing else ""),
            (Level.WARN, f"{skipped} messages could not be read" if skipped else ""),
            self.samples.verdict(),
            (Level.OK, "showing the twin"),
        )


def run(arguments: Sequence[str], stop: StopRequest) -> None:
    """Show the twin of this domain until asked to stop; `drill-twin watch` explains the arguments."""
    from drill_twin_dashboard.live.server import PageServer

    parser = argparse.ArgumentParser(prog="watch", description=LivePage.PURPOSE)
    parser.add_argument("--host", default="127.0.0.1", help="address to listen on (%(default)s)")
    parser.add_argument("--port", type=int, default=8000, help="port of the page; 0: a free one (%(default)s)")
    parser.add_argument("--allow-host", action="append", default=[], help="name of this server; repeatable")
    parser.add_argument("--limit", action="append", default=[], help="limit, as torque_high=12 kN m; repeatable")
    parser.add_argument("--units", choices=[*SYSTEMS], default="", help="units of the page (the scene's)")
    parser.add_argument("--no-browser", action="store_true", help="do not open the browser")
    parser.add_argument("--foxglove", type=int, help="port for viewers that speak the Foxglove protocol; 0: a free one")
    given, ros = parser.parse_known_args(arguments)
    limits = [parse_limit(text) for text in given.limit]
    with ExitStack() as ends:
        context = init_context(ros, stop)
        ends.callback(context.try_shutdown)
        with stop.at_once(), readable_refusal():
            viewers = None if given.foxglove is None else FoxgloveServer(given.host, given.foxglove, given.allow_host)
            if viewers is not None:
                ends.callback(viewers.close)
            node = LivePage(context, viewers)
            node.page_state.units = given.units
            for limit in limits:
                node.page_state.take(limit)
        server = PageServer(
            node.snapshot, node.on_request, history=node.page_state.history, host=given.host, port=given.port,
            allowed_hosts=given.allow_host,
        )  # fmt: skip
        ends.callback(server.close)
        server.links.show(f"the twin of ROS_DOMAIN_ID={context.get_domain_id()}")
        if viewers is not None:
            print(f"for Foxglove: {viewers.url}", flush=True)
        if not given.no_browser:
            server.links.open_browser()
        run_in_order(node, stop)
