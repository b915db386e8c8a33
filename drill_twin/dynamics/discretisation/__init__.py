# SPDX-License-Identifier: Apache-2.0
"""From a scene to the discrete model: elements, step, wellbore, boundary conditions, initial state."""
