# SPDX-License-Identifier: Apache-2.0
"""Values that a run reports of itself in `/diagnostics`: timing, rejected steps, missing effects, drilling progress."""
