# SPDX-License-Identifier: Apache-2.0
"""The twin of a scene: dynamics advance it, the step guard checks each frame, the observer reads it out."""
