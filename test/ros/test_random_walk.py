# SPDX-License-Identifier: Apache-2.0
"""A random walk over the life cycle, services, parameters and messages of every node; a client of plain rclpy asks.

Nobody dies, every request is answered in time, the state is what the services say it is, and a signal ends the node
with exit code 0, whatever came before.
"""

import importlib
import math
import signal
import time
from collections import Counter
from contextlib import suppress

import numpy as np
import pytest
from lifecycle_msgs.srv import ChangeState, GetAvailableStates, GetAvailableTransitions, GetState
from ports import free_port
from random_messages import NUMBERS, TEXTS, Oddities
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import DescribeParameters, GetParameters, ListParameters, SetParameters, SetParametersAtomically
from rclpy.node import NodeNameNonExistentError
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_srvs.srv import Trigger

from drill_twin.io.messages.topics import DIAGNOSTICS
from drill_twin.ros.entry_points import node_names
from drill_twin.scene import load_scene

STEPS, OF_A_NIGHT = 300, 1000
ANSWER = 60.0
"""Longest wait for an answer [s]; a node answers within a second, unless the machine is loaded."""
SEED = 41
LATCHED = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)
STATES = {1: "unconfigured", 2: "inactive", 3: "active"}
LEADS_TO = {(1, 1): 2, (2, 2): 1, (2, 3): 3, (3, 4): 2}
"""State that a transition (configure 1, clean up 2, activate 3, deactivate 4) leads to from a state."""
SHUTDOWN = {1: 5, 2: 6, 3: 7}
LABELS = {1: "configure", 2: "cleanup", 3: "activate", 4: "deactivate"}
LATER = ("step", "step_simulation")
"""Services that answer once their frames are done, or something has ended them."""
NUMBERED = (0, 1, 50, 10**5, -(2**63))
RESTS = {"gateway": 0.8}
"""Share of the turns at which a node, whose configuration takes seconds, is activated again and not cleaned up."""
STOPS_A_RUN = ("max_weight_on_bit", "max_speed", "negative_commands", "start_offset")
"""Parameters with which commands are followed that no string would bear, or a replay begins behind the end of its bag:
a run then ends with exit code 1, or a node is not configured, rightly."""


class Walk:
    """One node, its process, and what a stranger does to it."""

    def __init__(self, bench, node, given):
        self.bench, self.node, self.given = bench, node, given
        self.rng = np.random.default_rng([SEED, list(node_names()).index(node)])
        self.odd = Oddities(self.rng)
        self.clients, self.publishers, self.later, self.ends = {}, {}, [], []
        self.state, self.parameters, self.taken = 1, [], Counter()
        self.scene = load_scene("pa6_bench").to_yaml()
        self.begin()

    def begin(self):
        """Start the process, and wait until it answers."""
        self.process = self.bench.start(self.node, autostart=False, **self.given)
        self.bench.until(lambda: "waiting to be configured" in self.process.text or self.process.code is not None)
        self.state = 1
        self.later.clear()

    def ask(self, name, kind, request, within=ANSWER):
        """The answer of a service; None for one of `LATER`."""
        client = self.clients.get(name)
        if client is None:
            client = self.clients[name] = self.bench.node.create_client(kind, name)
        self.until(client.service_is_ready, ANSWER, f"the service {name}")
        answer, begun = client.call_async(request), time.monotonic()
        if name.rpartition("/")[2] in LATER:
            self.later.append(answer)
            return None
        self.until(answer.done, within, f"an answer of {name} to {request}")
        self.taken["slow"] += time.monotonic() - begun > 1.0
        return answer.result()

    def until(self, happened, seconds, what):
        end = time.monotonic() + seconds
        while not happened():
            self.alive()
            if time.monotonic() > end:
                last = self.bench.statuses.get(self.node)
                pytest.fail(f"waited {seconds:g} s for {what}; state {STATES[self.state]}; {last}\n{self.process.text}")
            self.bench.spin(0.001)

    def alive(self):
        code = self.process.code
        assert code is None, f"{self.node} ended with {code} in state {STATES[self.state]}:\n{self.process.text}"

    # --- steps --------------------------------------------------------------------------------------------------

    def change_state(self):
        """A transition that is possible now, most of the time, or any other, by number or by label."""
        possible = [number for state, number in LEADS_TO if state == self.state]
        if self.rng.random() < 0.3:
            possible = [0, 1, 2, 3, 4, 8, 10, 60, 99]
        elif self.state == 2 and self.rng.random() < RESTS.get(self.node, 0.0):
            possible = [3]
        number = self.odd.one_of(possible)
        request = ChangeState.Request()
        request.transition.id = number
        if self.rng.random() < 0.2:
            request.transition.id, request.transition.label = 0, LABELS.get(number, self.odd.one_of(TEXTS))
            number = number if number in LABELS or request.transition.label else 0
        wanted = LEADS_TO.get((self.state, number), self.state)
        # A configure that compiles or imports may take longer; it reports its progress.
        answer = self.ask(f"/{self.node}/change_state", ChangeState, request, 180.0 if number == 1 else ANSWER)
        assert answer.success == (wanted != self.state), (number, STATES[self.state], self.process.text)
        self.state = wanted
        self.compare_state()

    def compare_state(self):
        """What the node says of its state is what its transitions have led to."""
        said = self.ask(f"/{self.node}/get_state", GetState, GetState.Request()).current_state.label
        assert said == STATES[self.state], self.process.text
        if self.state < 3:  # frames are left undone
            for answer in self.later:
                self.until(answer.done, ANSWER, "the answer to a step that was ended")
            self.later.clear()

    def look(self):
        """What every lifecycle node answers."""
        kind, name = self.odd.one_of([
            (GetAvailableStates, "get_available_states"), (GetAvailableTransitions, "get_available_transitions"),
            (GetAvailableTransitions, "get_transition_graph"), (GetState, "get_state"),
        ])  # fmt: skip
        self.ask(f"/{self.node}/{name}", kind, kind.Request())

    def known(self, what):
        """Names and types of its subscriptions or services, once the graph knows the node."""
        read, found = getattr(self.bench.node, f"get_{what}_names_and_types_by_node"), []

        def is_there():
            with suppress(NodeNameNonExistentError):
                found.append(read(self.node, "/"))
            return bool(found)

        self.until(is_there, ANSWER, "the node in the graph")
        return found[0]

    def call(self):
        """One of the services of its own, that it has now."""
        offered = self.known("service")
        own = [name for name, types in offered if types == ["std_srvs/srv/Trigger"] and not name.endswith("/stop")]
        if own and self.state > 1:
            self.ask(self.odd.one_of(sorted(own)), Trigger, Trigger.Request())

    def set_parameters(self):
        """Parameters that it has or has not, with values that it admits or does not."""
        if not self.parameters:
            found = self.ask(f"/{self.node}/list_parameters", ListParameters, ListParameters.Request())
            self.parameters = [name for name in found.result.names if name not in STOPS_A_RUN]
        names = [self.odd.one_of([*self.parameters, "no_such", ""]) for _ in range(int(self.rng.integers(1, 3)))]
        given = [Parameter(name=name, value=self.value()) for name in names]
        kind, name = self.odd.one_of([
            (SetParameters, "set_parameters"), (SetParametersAtomically, "set_parameters_atomically"),
        ])  # fmt: skip
        self.ask(f"/{self.node}/{name}", kind, kind.Request(parameters=given))

    def value(self):
        number = self.odd.one_of(NUMBERS)
        return self.odd.one_of([
            ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=number),
            ParameterValue(type=ParameterType.PARAMETER_INTEGER, integer_value=self.odd.one_of(NUMBERED)),
            ParameterValue(type=ParameterType.PARAMETER_STRING, string_value=self.odd.one_of(TEXTS)),
            ParameterValue(type=ParameterType.PARAMETER_BOOL, bool_value=bool(number > 0.0)),
            ParameterValue(type=int(self.odd.one_of([0, 200]))),
        ])  # fmt: skip

    def read_parameters(self):
        """Parameters by name, some of which it does not have."""
        kind, name = self.odd.one_of([(GetParameters, "get_parameters"), (DescribeParameters, "describe_parameters")])
        self.ask(f"/{self.node}/{name}", kind, kind.Request(names=[self.odd.one_of([*self.parameters, *TEXTS])]))

    def publish(self):
        """A message on a topic that it reads: of odd contents, or a scene."""
        heard = self.known("subscriber")
        topics = sorted(topic for topic, _ in heard if topic not in {DIAGNOSTICS, "/parameter_events"})
        if not topics:
            return
        topic = self.odd.one_of(topics)
        types = dict(heard)[topic]
        if topic not in self.publishers:
            package, _, name = types[0].split("/")
            kind = getattr(importlib.import_module(f"{package}.msg"), name)
            self.publishers[topic] = kind, self.bench.node.create_publisher(kind, topic, LATCHED)
        kind, publisher = self.publishers[topic]
        message = self.odd.message(kind)
        if topic == "/twin/scene" and self.rng.random() < 0.5:
            message.data = self.scene
        if topic == "/rig/command" and self.rng.random() < 0.5:
            message = kind(name=["bit_axial", "top_drive"], velocity=[math.nan, 12.0], effort=[40.0, math.nan])
        publisher.publish(message)

    def wait(self):
        """Let it run for a moment."""
        self.bench.spin(0.02)

    def end_and_begin(self):
        """Shut it down by its life cycle or by a signal; it ends with 0, and another begins."""
        if self.rng.random() < 0.5:
            request = ChangeState.Request()
            request.transition.id = SHUTDOWN[self.state]
            self.clients[f"/{self.node}/change_state"].call_async(request)  # it may end before it has answered
            assert self.process.wait(60.0) == 0, self.process.text
        else:
            self.end_by_a_signal()
        self.check_log()
        for client in self.clients.values():
            self.bench.node.destroy_client(client)
        self.clients.clear()
        # a client that finds the services of the last process would ask it, and get no answer
        self.bench.until(lambda: self.node not in self.bench.node.get_node_names(), ANSWER, "the node to be forgotten")
        self.begin()

    def check_log(self):
        text = self.process.text
        assert "Traceback" not in text, text
        assert "\x1b" not in text, text

    def run(self, steps):
        """Take steps, then end the node."""
        ways = (self.change_state, self.look, self.call, self.set_parameters, self.read_parameters, self.publish,
                self.wait, self.end_and_begin)  # fmt: skip
        shares = (0.15, 0.05, 0.16, 0.12, 0.03, 0.4, 0.085, 0.005)
        for k in self.rng.choice(len(ways), steps, p=shares):
            self.taken[ways[k].__name__] += 1
            ways[k]()
            self.alive()
        self.compare_state()
        self.end_by_a_signal()
        self.check_log()

    def end_by_a_signal(self):
        """End it by SIGINT or SIGTERM in whatever it does, and keep the time that it took."""
        begin = time.monotonic()
        self.process.send(self.odd.one_of([signal.SIGINT, signal.SIGTERM]))
        assert self.process.wait(60.0) == 0, self.process.text
        self.ends.append(time.monotonic() - begin)


@pytest.mark.parametrize(
    "steps", [pytest.param(STEPS, marks=pytest.mark.long), pytest.param(OF_A_NIGHT, marks=pytest.mark.nightly)]
)
@pytest.mark.parametrize("node", node_names())
def test_a_random_walk_leaves_every_node_alive_and_true_to_its_state(bench, small_bag, node, steps):
    given = {
        "simulator": {"wait_for_command": False, "checkpoint": str(bench.folder / "run.npz")},
        "rig_driver": {"wait_for": ""},
        "recorder": {"bag": ""},
        "replayer": {"bag": str(small_bag), "loop": True, "rate": 0.0},
        "estimator": {"members": 4},
        "gateway": {"port": free_port()} if node == "gateway" else {},
    }
    walk = Walk(bench, node, given.get(node, {}))
    walk.run(steps)
    print(node, dict(walk.taken), f"ended by {len(walk.ends)} signals, the slowest within {max(walk.ends):.2f} s")
