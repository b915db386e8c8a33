# SPDX-License-Identifier: Apache-2.0
"""Base of all nodes: loop, topics, parameters, quality of service, diagnostics, start-up and shutdown."""
