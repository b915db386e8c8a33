# SPDX-License-Identifier: Apache-2.0
"""Commands of the studies, each of many runs."""
