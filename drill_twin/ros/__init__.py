# SPDX-License-Identifier: Apache-2.0
"""ROS 2 nodes; the only package that imports rclpy.

simulator, rig_driver, analyzer, recorder and replayer are one process each; twin is the first four in one process;
demo starts them as processes and supervises them.
"""
