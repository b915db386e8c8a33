# SPDX-License-Identifier: Apache-2.0
"""Gateway to rig software: OPC UA with the semantics of D-WIS, without ROS."""
