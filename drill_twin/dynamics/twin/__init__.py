# SPDX-License-Identifier: Apache-2.0
"""Twin of a scene: dynamics in time, step guard, frames, energy audit, checkpoints."""
