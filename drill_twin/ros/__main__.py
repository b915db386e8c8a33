# SPDX-License-Identifier: Apache-2.0
"""`python -m drill_twin.ros NAME`: any node or program, without an installed command."""

import sys

from drill_twin.ros.entry_points import end, start

end(start("".join(sys.argv[1:2]), sys.argv[2:]))
