# SPDX-License-Identifier: Apache-2.0
"""Drawing of the string for viewers: positions, markers, orientations, transforms."""
