# SPDX-License-Identifier: Apache-2.0
"""Nodes on machines: discovery, child processes, processor load, security."""
