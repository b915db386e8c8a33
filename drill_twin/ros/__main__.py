# SPDX-License-Identifier: Apache-2.0
"""`python -m drill_twin.ros NAME`: any node or program, without an installed command."""

import sys

from drill_twin.ros.entry_points import end, executables, start

if len(sys.argv) < 2 or sys.argv[1] not in executables():
    print(f"usage: python -m drill_twin.ros {{{','.join(executables())}}} [--help] [--ros-args ...]", file=sys.stderr)
    sys.exit(2)
end(start(sys.argv[1], sys.argv[2:]))
