# SPDX-License-Identifier: Apache-2.0
"""Blocks of a scene file: string, hole, rig, numerics, effects."""
