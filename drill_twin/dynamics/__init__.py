# SPDX-License-Identifier: Apache-2.0
"""Equations of motion of a scene, and what is computed from them: in time, at rest and in steady whirl."""
