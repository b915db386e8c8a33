# SPDX-License-Identifier: Apache-2.0
"""Entry point of `python -m drill_twin.cli`."""

from drill_twin.cli import main

main()
