# SPDX-License-Identifier: Apache-2.0
"""A digital twin of a flexible drillstring as a ROS 2 node set.

Data flows one way: scene -> rod and effects -> twin -> nodes and session -> report.
"""

__version__ = "0.1.0"
