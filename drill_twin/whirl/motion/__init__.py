# SPDX-License-Identifier: Apache-2.0
"""Motion states: classification, hysteresis, timeline, irregularity, stick-slip."""
