# SPDX-License-Identifier: Apache-2.0
"""Commands that come to `drill-twin` by the entry points of this distribution."""
