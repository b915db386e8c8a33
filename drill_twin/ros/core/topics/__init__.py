# SPDX-License-Identifier: Apache-2.0
"""Topics of a node: publishers, subscriptions as bytes, quality of service, dropped messages."""
