# SPDX-License-Identifier: Apache-2.0
"""The lateral formulation: two lateral unknowns per node and their slopes."""
