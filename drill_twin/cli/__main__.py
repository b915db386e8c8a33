# SPDX-License-Identifier: Apache-2.0
"""`python -m drill_twin.cli`."""

from drill_twin.cli import main

main()
