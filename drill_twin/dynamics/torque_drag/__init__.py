# SPDX-License-Identifier: Apache-2.0
"""Torque, drag and buckling of a string without a run: each operation of the rig as a balance of forces."""
