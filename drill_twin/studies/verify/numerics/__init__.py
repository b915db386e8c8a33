# SPDX-License-Identifier: Apache-2.0
"""Exact checks of the numerics: conservation, orders of convergence, symmetry, formulations."""
