# SPDX-License-Identifier: Apache-2.0
"""Files of bags, written: MCAP that survives kill -9."""
