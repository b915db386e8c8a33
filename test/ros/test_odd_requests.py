# SPDX-License-Identifier: Apache-2.0
"""Odd parameters, giant messages and absurd stamps from the network are refused in a short line; the run goes on."""

import math

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters, SetParametersAtomically
from sensor_msgs.msg import JointState

from drill_twin.io.messages.topics import DIAGNOSTICS, MARKS_STATE, RIG_COMMAND, RIG_STATE
from drill_twin.ros.core.queues import DropCounter

TEXT = ParameterType.PARAMETER_STRING
ODD_VALUES = (
    ParameterValue(type=200),
    ParameterValue(type=ParameterType.PARAMETER_NOT_SET),
    ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=math.nan),
    ParameterValue(type=ParameterType.PARAMETER_INTEGER, integer_value=-(2**63)),
    ParameterValue(type=ParameterType.PARAMETER_DOUBLE_ARRAY, double_array_value=[1.0] * 10_000),
    *(ParameterValue(type=TEXT, string_value=text) for text in ("\x1b[31m\u202e", "x" * 1_000_000, "9" * 5000)),
)
LONGEST_LINE = 1000


@pytest.mark.fault("parameters of unknown type, of a million characters, not a number", "refused in a line")
def test_odd_parameters_are_refused_and_the_nodes_go_on(bench):
    names = {"simulator": ("command_timeout", "scene", ""), "rig_driver": ("wob", "no_such")}
    processes = {
        "simulator": bench.start("simulator", wait_for_command=False),
        "rig_driver": bench.start("rig_driver", wait_for="simulator"),
    }
    bench.until_ready(*processes)
    for node, process in processes.items():
        for value in ODD_VALUES:
            parameters = [Parameter(name=name, value=value) for name in names[node]]
            results = bench.call(f"/{node}/set_parameters", SetParameters.Request(parameters=parameters), SetParameters)
            assert [result.successful for result in results.results] == [False] * len(parameters), value.type
            assert all(len(result.reason) < LONGEST_LINE for result in results.results)
            assert all(result.reason.isprintable() for result in results.results)
        request = SetParametersAtomically.Request(parameters=[Parameter(name="scene", value=ODD_VALUES[0])])
        assert not bench.call(f"/{node}/set_parameters_atomically", request, SetParametersAtomically).result.successful
        assert process.end() == 0, process.text
        assert "Traceback" not in process.text
        assert max(map(len, process.text.splitlines())) < LONGEST_LINE


@pytest.mark.fault("names of millions of characters and escape sequences on the topics", "told in a line; time goes on")
def test_giant_and_odd_messages_are_told_in_a_line(bench, tmp_path):
    processes = {
        "simulator": bench.start("simulator", wait_for_command=False),
        "analyzer": bench.start("analyzer"),
        "recorder": bench.start("recorder", bag=str(tmp_path / "bag")),
    }
    bench.until_ready(*processes)
    odd = [
        JointState(name=["x" * 10] * 100_000, effort=[1.0] * 100_000),
        JointState(name=["y" * 5_000_000], effort=[1.0]),
        JointState(name=["\x1b[31mbit\u202e"], effort=[1.0]),
        JointState(name=["bit"] * 3, effort=[math.nan, math.inf, -1e308], position=[0.0] * 1000),
    ]
    odd[3].header.stamp.sec, odd[3].header.stamp.nanosec = -(2**31), 2**32 - 1
    for topic in (RIG_COMMAND, RIG_STATE, MARKS_STATE):
        publisher = bench.publisher(topic)
        for message in odd:
            publisher.publish(message)
            bench.spin(0.2)
        bench.node.destroy_publisher(publisher)
    entry = DiagnosticStatus(
        name="rig2/simulator", message="\x1b[31m" * 100_000, values=[KeyValue(key="k", value="9" * 9**5)]
    )
    statuses = bench.publisher(DIAGNOSTICS)
    statuses.publish(DiagnosticArray(status=[entry] * 3))
    before = bench.simulated_time()
    bench.until(lambda: bench.simulated_time() > before, what="the simulated time to go on")
    assert bench.statuses["recorder"].values["dropped"] == "0", "the numbers of two publishers are no loss"
    for process in processes.values():
        assert process.end() == 0, process.text
        assert "Traceback" not in process.text
        assert max(map(len, process.text.splitlines())) < LONGEST_LINE
        assert "\x1b" not in process.text


@pytest.mark.parametrize(("numbers", "publishers", "dropped"), [
    ((1, 2, 5, 6), 1, 2),  # a gap of one publisher
    ((100, 1, 101, 2, 102), 2, 0),  # two publishers
    ((100, 1, 101, 102), 1, 0),  # the second one has come and gone
    ((100, 101, 1, 2), 1, 0),  # a publisher that began again
])  # fmt: skip
def test_only_a_gap_of_one_publisher_is_a_loss(numbers, publishers, dropped):
    counter = DropCounter()
    for number in numbers:
        counter.take("t", {"received_timestamp": 0, "publication_sequence_number": number})
    counter.confirm_gaps(lambda _: publishers)
    assert counter.dropped.total() == dropped
