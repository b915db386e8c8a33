# SPDX-License-Identifier: Apache-2.0
"""Steady whirl of a string: states under one command, branches over a parameter, imperfections."""
