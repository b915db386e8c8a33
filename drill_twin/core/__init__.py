# SPDX-License-Identifier: Apache-2.0
"""Array types and compiler flags shared by all packages."""
