# SPDX-License-Identifier: Apache-2.0
"""Version of the package, for bags, pages and messages; `setup.py` and `package.xml` have the same."""

__version__ = "0.1.0"
