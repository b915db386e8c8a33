# SPDX-License-Identifier: Apache-2.0
"""Puts the sets of effects that test/composition covers all pairs with on the path."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "composition"))
