# SPDX-License-Identifier: Apache-2.0
"""The ROS 2 nodes: the only place that knows rclpy.

simulator, rig_driver, analyzer, recorder and replayer are one process each; twin is the first four in one process;
demo starts them as processes and looks after them.
"""
