# SPDX-License-Identifier: Apache-2.0
"""Checks of an installation and of the nodes in a domain, for `drill-twin ros doctor`; only `graph` needs rclpy."""

from drill_twin.core.errors import DrillTwinError
from drill_twin.ros.core.stop_request import StopRequest
from drill_twin.ros.doctor.installation import ROS, Check, Verdict, installation, ros_installation, ros_present


def examine(seconds: float) -> list[Check]:
    """Check the installation and, where ROS is there, listen to the domain for a time [s]; 0: do not listen."""
    checks = [*installation(), *ros_installation()]
    broken = any(check.verdict is Verdict.PROBLEM and check.section == ROS for check in checks)
    if seconds and ros_present() and not broken:
        try:
            checks += _examine_domain(seconds)
        except DrillTwinError as error:
            checks.append(Check(ROS, "node", str(error), Verdict.PROBLEM, "mend this first, then ask again"))
    return checks


def _examine_domain(seconds: float) -> list[Check]:
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
