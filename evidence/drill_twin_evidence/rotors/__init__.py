# SPDX-License-Identifier: Apache-2.0
"""Rotors with discs and bearings against finite elements of their own, written from the textbook."""
