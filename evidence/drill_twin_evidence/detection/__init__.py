# SPDX-License-Identifier: Apache-2.0
"""Detection study: findings of the analyzer against the ground truth of labelled motions.

The ground truth (`ground_truth`, `signals`) shares no code with `drill_twin.whirl`: it is prescribed, or computed from
the full state of a simulated run with non-causal windows.
"""
