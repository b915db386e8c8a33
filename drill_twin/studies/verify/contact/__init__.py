# SPDX-License-Identifier: Apache-2.0
"""Exact checks of contact: wall, bit on rock, stick-slip."""
