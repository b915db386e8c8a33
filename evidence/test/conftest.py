# SPDX-License-Identifier: Apache-2.0
"""What the tests of the package share too: made-up frames, repeatable random examples."""

from drill_twin.core.process import use_one_thread_of_blas

use_one_thread_of_blas()  # as in test/conftest.py

from made_up import make_frame  # noqa: E402

__all__ = ["make_frame"]
