# SPDX-License-Identifier: Apache-2.0
"""Whirl with two frequencies: parts of a string that whirl at speeds of their own."""
