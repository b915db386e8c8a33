# SPDX-License-Identifier: Apache-2.0
"""Exact checks of statics: bending, buckling, a string that lies in the hole, curved holes."""
