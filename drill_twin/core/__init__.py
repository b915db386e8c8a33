# SPDX-License-Identifier: Apache-2.0
"""Base of all rooms: arrays, errors, units, files, the compiler, and the version of the package."""

__version__ = "0.1.0"
"""For bags, pages and messages; `setup.py` and `package.xml` have the same."""
