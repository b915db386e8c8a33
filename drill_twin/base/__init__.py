# SPDX-License-Identifier: Apache-2.0
"""What every room uses: array types, compiler flags of kernels, constants."""
