# SPDX-License-Identifier: Apache-2.0
"""Coverage of the intervals that a fit gives."""
