# SPDX-License-Identifier: Apache-2.0
"""Numeric constants of the whirl analysis: what each says that it rests on, and what changes where it is varied."""
