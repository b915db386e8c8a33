# SPDX-License-Identifier: Apache-2.0
"""Motion states of the marks and the string, and stick-slip of the bit."""
