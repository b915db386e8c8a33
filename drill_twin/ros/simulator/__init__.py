# SPDX-License-Identifier: Apache-2.0
"""The simulator node, composed of its parts."""
