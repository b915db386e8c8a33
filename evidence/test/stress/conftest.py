# SPDX-License-Identifier: Apache-2.0
"""Path of the sets of effects in test/composition."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[3] / "test" / "composition"))
