# SPDX-License-Identifier: Apache-2.0
"""The rod: mesh, state layout, kinematics of a point and the elastic section."""
