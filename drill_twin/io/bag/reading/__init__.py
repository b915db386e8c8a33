# SPDX-License-Identifier: Apache-2.0
"""Files of bags, read: MCAP and SQLite, complete, truncated or hostile."""
