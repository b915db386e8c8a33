# SPDX-License-Identifier: Apache-2.0
"""Which effects a scene calls for: what each one costs, and what changes without it."""

from drill_twin.studies.ablation.ablation import Ablation, Change, ablate, groups

__all__ = ["Ablation", "Change", "ablate", "groups"]
