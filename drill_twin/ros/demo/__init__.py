# SPDX-License-Identifier: Apache-2.0
"""Demo: all nodes as processes, observed and reported."""
