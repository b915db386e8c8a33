# SPDX-License-Identifier: Apache-2.0
"""Deployment of the nodes: discovery and security."""
