# SPDX-License-Identifier: Apache-2.0
"""Path of the scenes that evidence/test/verify shares."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[3] / "evidence" / "test" / "verify"))
