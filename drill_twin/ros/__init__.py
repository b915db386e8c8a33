# SPDX-License-Identifier: Apache-2.0
"""ROS 2 nodes; the only package that imports rclpy.

simulator, rig_driver, analyzer, recorder and replayer are one process each; twin runs the first three in one process,
and more nodes where a flag asks for them; demo runs the first four so, and reports what they did.
"""
