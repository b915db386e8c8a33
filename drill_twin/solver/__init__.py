# SPDX-License-Identifier: Apache-2.0
"""From a scene's effects to one compiled time loop: assembly, banded solve, implicit midpoint, composition."""
