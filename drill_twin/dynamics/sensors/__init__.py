# SPDX-License-Identifier: Apache-2.0
"""Measurements of a rig: from the state of the string to readings with noise, bias, range, resolution and delay."""
