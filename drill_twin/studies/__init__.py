# SPDX-License-Identifier: Apache-2.0
"""Studies: many runs or records, and the figures and tables that are printed of them."""
