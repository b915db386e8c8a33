# SPDX-License-Identifier: Apache-2.0
"""Time integration: implicit midpoint loop, assembly and linear solvers, generation of kernels."""
