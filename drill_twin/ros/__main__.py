# SPDX-License-Identifier: Apache-2.0
"""`python -m drill_twin.ros NODE`: any node, or the demo, without an installed command."""

import sys

from drill_twin.ros.entry_points import NODES, start

if len(sys.argv) < 2 or sys.argv[1] not in NODES:
    print(f"usage: python -m drill_twin.ros {{{','.join(NODES)}}} [--help] [--ros-args ...]", file=sys.stderr)
    sys.exit(2)
sys.exit(start(sys.argv[1], sys.argv[2:]))
