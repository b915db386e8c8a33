# SPDX-License-Identifier: Apache-2.0
"""The demo: all nodes as processes, observed and reported."""
