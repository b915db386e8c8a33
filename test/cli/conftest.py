# SPDX-License-Identifier: Apache-2.0
"""Fixtures of the command line (`test/command_fixtures.py`)."""

from command_fixtures import call, inside, process, start

__all__ = ["call", "inside", "process", "start"]
