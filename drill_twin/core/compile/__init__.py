# SPDX-License-Identifier: Apache-2.0
"""Compiler of kernels and what it keeps on disk; the one room that uses private parts of numba."""
