# SPDX-License-Identifier: Apache-2.0
"""What the tests of the package share too: made-up frames, repeatable random examples."""

from made_up import make_frame

__all__ = ["make_frame"]
