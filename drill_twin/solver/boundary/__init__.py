# SPDX-License-Identifier: Apache-2.0
"""The ends of the string in the equations: rig at the top, frame of the bit."""
