# SPDX-License-Identifier: Apache-2.0
"""Sub-commands that ask a question of many runs."""
