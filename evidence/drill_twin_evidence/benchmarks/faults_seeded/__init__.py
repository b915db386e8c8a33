# SPDX-License-Identifier: Apache-2.0
"""Small faults put into a copy of the package one at a time, each with the tests of its room that must catch it."""
