# SPDX-License-Identifier: Apache-2.0
"""The string in space up to a joint, and above it along the hole: see `formulation`."""
