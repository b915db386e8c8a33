# SPDX-License-Identifier: Apache-2.0
"""Figures and data of modes, critical speeds and whirl states (docs/whirl_states.md)."""
