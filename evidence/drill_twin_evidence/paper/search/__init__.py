# SPDX-License-Identifier: Apache-2.0
"""Search for a set of numbers that meets the paper, and the map of the published numbers that exclude each other."""
