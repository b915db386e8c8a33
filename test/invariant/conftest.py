# SPDX-License-Identifier: Apache-2.0
"""Puts the shared scenes and signal tools of the exact checks on the path."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "verify"))
