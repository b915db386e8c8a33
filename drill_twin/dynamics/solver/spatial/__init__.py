# SPDX-License-Identifier: Apache-2.0
"""The spatial formulation: seven unknowns per node, stretch and torsion included."""
