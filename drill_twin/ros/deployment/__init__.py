# SPDX-License-Identifier: Apache-2.0
"""Deployment of the nodes: discovery, child processes, processor load, security."""
