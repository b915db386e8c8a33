# SPDX-License-Identifier: Apache-2.0
"""Ablation study: cost of each effect of a scene, and change of the results without it."""

from drill_twin.studies.ablation.ablation import Ablation, Change, ablate, groups

__all__ = ["Ablation", "Change", "ablate", "groups"]
