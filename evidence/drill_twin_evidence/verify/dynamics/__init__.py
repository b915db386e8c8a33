# SPDX-License-Identifier: Apache-2.0
"""Exact checks of dynamics: frequencies, waves, torsion, damping, mud, rotor."""
