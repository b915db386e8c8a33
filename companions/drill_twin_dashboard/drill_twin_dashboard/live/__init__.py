# SPDX-License-Identifier: Apache-2.0
"""Live page in the browser, without ROS: string in the hole, orbits, motion, and sliders for two set-points."""
