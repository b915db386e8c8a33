# SPDX-License-Identifier: Apache-2.0
"""Figures of a report, one a file: each takes a recording and returns a matplotlib figure.

Those over time have the same width and margins, so that one below the other they share their time axis.
"""
