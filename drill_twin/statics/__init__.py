# SPDX-License-Identifier: Apache-2.0
"""Static equilibrium, and runs that start in it."""
