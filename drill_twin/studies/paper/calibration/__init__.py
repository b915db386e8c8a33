# SPDX-License-Identifier: Apache-2.0
"""The search for the numbers that the paper leaves open."""
