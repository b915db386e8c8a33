# SPDX-License-Identifier: Apache-2.0
"""The paper, reproduced: every published number with ours beside it (doi 10.3389/feart.2024.1396784)."""
