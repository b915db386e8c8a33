# SPDX-License-Identifier: Apache-2.0
"""Checks of an installation and of the nodes in a domain, for `drill-twin ros doctor`; only `graph` needs rclpy."""

import drill_twin.ros.doctor.installation as own
from drill_twin.core.errors import DrillTwinError
from drill_twin.ros.core.stop_request import StopRequest


def examine(seconds: float) -> list[own.Check]:
    """Check the installation and, where ROS is there, listen to the domain for a time [s]; 0: do not listen."""
    checks = [*own.installation(), *own.ros_installation()]
    broken = any(check.verdict is own.Verdict.PROBLEM and check.section == own.ROS for check in checks)
    if seconds and own.ros_present() and not broken:
        try:
            checks += _examine_domain(seconds)
        except DrillTwinError as error:
            checks.append(
                own.Check(own.ROS, "node", str(error), own.Verdict.PROBLEM, "mend this first, then ask again")
            )
    return checks


def _examine_domain(seconds: float) -> list[own.Check]:
    from rclpy.executors import SingleThreadedExecutor
    from rclpy.node import Node

    from drill_twin.ros.core.node_main import init_context
    from drill_twin.ros.deployment import readable_refusal
    from drill_twin.ros.doctor.graph import NAME, graph_checks, observe

    context = init_context([], StopRequest())
    try:
        with readable_refusal():
            node = Node(NAME, context=context, enable_rosout=False, start_parameter_services=False)
        executor = SingleThreadedExecutor(context=context)
        executor.add_node(node)
        return list(graph_checks(observe(node, executor.spin_once, seconds)))
    finally:
        context.try_shutdown()
