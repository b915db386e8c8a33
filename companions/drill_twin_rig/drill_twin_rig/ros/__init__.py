# SPDX-License-Identifier: Apache-2.0
"""Gateway node: the twin in the rig's own software."""
