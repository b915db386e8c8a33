# SPDX-License-Identifier: Apache-2.0
"""Cases of the numerics: conservation, orders of convergence, symmetry, formulations."""
