# SPDX-License-Identifier: Apache-2.0
"""Rig driver node."""
