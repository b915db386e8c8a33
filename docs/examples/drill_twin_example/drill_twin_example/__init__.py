# SPDX-License-Identifier: Apache-2.0
"""An effect, a bit law and a schedule for drill_twin in a package of their own."""
