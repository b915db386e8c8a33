# SPDX-License-Identifier: Apache-2.0
"""A live page in the browser: the string in the hole, the orbits, the motion, and two sliders. Knows no ROS."""
