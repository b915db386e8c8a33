# SPDX-License-Identifier: Apache-2.0
"""How well the analyzer detects: labelled motions, their truth, and what the analyzer makes of them.

The truth (`truth`, `signals`) shares nothing with `drill_twin.whirl`: it is either prescribed or computed from the full
state of a simulated run, with windows that may look ahead.
"""
