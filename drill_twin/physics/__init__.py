# SPDX-License-Identifier: Apache-2.0
"""Mechanics of the string: its geometry and strains, and one file for each effect."""
