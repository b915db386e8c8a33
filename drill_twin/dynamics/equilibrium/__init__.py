# SPDX-License-Identifier: Apache-2.0
"""Static equilibrium and the initial state from it."""
