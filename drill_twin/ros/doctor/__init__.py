# SPDX-License-Identifier: Apache-2.0
"""Checks of an installation and of the nodes in a domain, for `drill-twin ros doctor`; only `graph` needs rclpy."""
